#include "acus/base/core/version.h"

#include <gmock/gmock.h>

#include "acus/base/core/provenance.h"

namespace acus {
namespace {

using testing::MatchesRegex;
using testing::StartsWith;

TEST(Version, IsTheNumberAndWhatDistinguishesBuilds) {
  EXPECT_THAT(VersionNumber(), MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+"));
  EXPECT_THAT(Version(), StartsWith(VersionNumber()));
  EXPECT_THAT(Version().substr(VersionNumber().size()),
              MatchesRegex("( \\([-A-Za-z0-9._/+]+\\))?"));
}

TEST(Version, IsInEveryProvenance) {
  EXPECT_EQ(Provenance().version, Version());
}

}  // namespace
}  // namespace acus
