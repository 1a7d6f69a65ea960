// docs/accuracy-and-time.md, docs/papers-claims.md and their figures are made from docs/templates
// and the results in docs/data. This test compares them; with ACUS_WRITE_DOCS set it writes them
// instead. Measuring anew: pipelines/accuracy-and-time.
#include <cstdlib>
#include <gtest/gtest.h>

#include "core/atomic_file.h"
#include "pages/page_folder.h"

namespace acus {
namespace {

TEST(AccuracyPages, AreWhatTheStoredResultsGive) {
  const std::filesystem::path docs = std::filesystem::path(ACUS_SOURCE_DIR) / "docs";
  const auto files = pages::MakePages(docs / "templates", docs / "data", pages::Claims::kMustHold);
  EXPECT_GT(files.size(), 5u);
  for (const auto& [name, text] : files) {
    if (std::getenv("ACUS_WRITE_DOCS") != nullptr) {
      WriteTextFile(docs / name, text);
      continue;
    }
    ASSERT_TRUE(std::filesystem::exists(docs / name))
        << name << " is missing; run pipelines/accuracy-and-time --from-stored";
    EXPECT_TRUE(ReadTextFile(docs / name) == text)
        << name << " is out of date; run pipelines/accuracy-and-time --from-stored";
  }
}

}  // namespace
}  // namespace acus
