#include "acus/base/core/csv.h"

#include <gmock/gmock.h>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

std::filesystem::path FileWith(std::string_view text) {
  static const testing_support::TemporaryFolder folder;
  const auto path = folder / "table.csv";
  WriteTextFile(path, text);
  return path;
}

TEST(CsvTable, ReadsColumnsByName) {
  const CsvTable table(FileWith("# a comment\ndepth_mm,force_n\r\n1,0.5\r\n\n2, -3e-2\n"));
  EXPECT_EQ(table.Numbers("depth_mm"), (std::vector<double>{1.0, 2.0}));
  EXPECT_EQ(table.Numbers("force_n"), (std::vector<double>{0.5, -0.03}));
}

TEST(CsvTable, NamesFileRowAndValueOfWhatIsWrong) {
  const auto message = [](std::string_view text) {
    return [text] { return CsvTable(FileWith(text)).Numbers("force_n"); };
  };
  EXPECT_THAT(message("force_n\n1\nnan\n"),
              ThrowsMessage<InputError>(HasSubstr("table.csv:3: force_n is 'nan'")));
  EXPECT_THAT(message("force_n\n1e999\n"), ThrowsMessage<InputError>(HasSubstr(":2: force_n")));
  EXPECT_THAT(message("force_n\n0x10\n"), ThrowsMessage<InputError>(HasSubstr(":2: force_n")));
  EXPECT_THAT(message("a,force_n\n1,2\n3\n"),
              ThrowsMessage<InputError>(HasSubstr(":3: has 1 cells")));
  EXPECT_THAT(message("force_m\n1\n"), ThrowsMessage<InputError>(HasSubstr("rename 'force_m'?")));
  EXPECT_THAT(message("a,a\n1,2\n"), ThrowsMessage<InputError>(HasSubstr("'a' appears twice")));
  EXPECT_THAT(message(""), ThrowsMessage<InputError>(HasSubstr("is empty")));
}

TEST(NumberText, ReadsBackAsTheSameBits) {
  for (const double value : {0.1, -1e-300, 1.0 / 3.0, 123456789.123456789}) {
    EXPECT_EQ(std::stod(NumberText(value)), value);
  }
}

}  // namespace
}  // namespace acus
