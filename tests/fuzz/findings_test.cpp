// What fuzzing found once stays mended: testdata/fuzz/READER/* is read or refused. The seeds, too.
#include <gtest/gtest.h>

#include "fuzz/readers.h"
#include "support/temporary_folder.h"

namespace acus::fuzz {
namespace {

namespace fs = std::filesystem;

class FuzzedReader : public testing::TestWithParam<Reader> {};

TEST_P(FuzzedReader, ReadsItsSeeds) {
  const testing_support::TemporaryFolder folder;
  const Reader& reader = GetParam();
  reader.write_seeds(folder / "");
  const std::vector<fs::path> seeds(fs::directory_iterator(folder / ""), fs::directory_iterator());
  EXPECT_FALSE(seeds.empty());
  for (const fs::path& seed : seeds) {
    const fs::path named = seed.string() + std::string(reader.extension);
    fs::rename(seed, named);
    ReadOrRefuse(reader, named);
  }
}

TEST_P(FuzzedReader, ReadsOrRefusesWhatOnceWasAFinding) {
  const testing_support::TemporaryFolder folder;
  const Reader& reader = GetParam();
  const fs::path findings = fs::path(ACUS_SOURCE_DIR) / "testdata" / "fuzz" / reader.name;
  if (!fs::exists(findings)) return;
  for (const auto& entry : fs::directory_iterator(findings)) {
    const fs::path named = folder / ("finding" + std::string(reader.extension));
    fs::copy_file(entry.path(), named, fs::copy_options::overwrite_existing);
    SCOPED_TRACE(entry.path());
    EXPECT_NO_THROW(ReadOrRefuse(reader, named));
  }
}

INSTANTIATE_TEST_SUITE_P(All, FuzzedReader, testing::ValuesIn(Readers().begin(), Readers().end()),
                         [](const auto& each) { return std::string(each.param.name); });

}  // namespace
}  // namespace acus::fuzz
