#include "acus/base/core/machine.h"

#include <gmock/gmock.h>

namespace acus {
namespace {

TEST(MachineName, NamesTheProcessorAndItsThreads) {
  EXPECT_THAT(MachineName(), testing::MatchesRegex(".+, [0-9]+ threads"));
  EXPECT_EQ(MachineName(), MachineName());
}

}  // namespace
}  // namespace acus
