// docs/accuracy-and-time.md, docs/papers-claims.md and their figures are made from docs/templates
// and the results in docs/data. This test compares them; with ACUS_WRITE_DOCS set it writes them
// instead. Measuring anew: pipelines/accuracy-and-time.
#include <cstdlib>
#include <gtest/gtest.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "benchmarks/page_folder.h"
#include "support/temporary_folder.h"

namespace acus {
namespace {

TEST(AccuracyPages, AreWhatTheStoredResultsGive) {
  const std::filesystem::path docs = std::filesystem::path(ACUS_SOURCE_DIR) / "docs";
  const auto files =
      benchmarks::MakePages(docs / "templates", docs / "data", benchmarks::Claims::kMustHold);
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

// A quick run has fewer settings: where text and tables miss them they say so.
TEST(AccuracyPages, AreMadeOfAFewSettingsToo) {
  const std::filesystem::path docs = std::filesystem::path(ACUS_SOURCE_DIR) / "docs";
  const testing_support::TemporaryFolder few;
  for (const auto& entry : std::filesystem::directory_iterator(docs / "data")) {
    const std::string text = ReadTextFile(entry.path());
    std::string kept;
    std::string knob_before;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
      const std::string line = text.substr(begin, end - begin);
      const std::string knob = line.substr(0, line.find(','));
      if (entry.path().extension() == ".json" || knob != knob_before) kept += line;
      knob_before = knob;
      begin = end;
    }
    WriteTextFile(few.path() / entry.path().filename(), kept);
  }
  const auto files =
      benchmarks::MakePages(docs / "templates", few.path(), benchmarks::Claims::kAreMarked);
  EXPECT_NE(files.at("accuracy-and-time.md").find("**(not measured in this run)**"),
            std::string::npos);
  EXPECT_THROW(benchmarks::MakePages(docs / "templates", few.path(), benchmarks::Claims::kMustHold),
               InputError);
}

}  // namespace
}  // namespace acus
