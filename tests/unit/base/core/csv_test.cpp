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
  EXPECT_THAT(message("PK\x03\x04..."), ThrowsMessage<InputError>(HasSubstr("a workbook")));
}

void ExpectCurve(std::string_view text) {
  const CsvTable table(FileWith(text));
  EXPECT_EQ(table.Numbers("time_s"), (std::vector<double>{0.0, 0.5, 1.0})) << text;
  EXPECT_EQ(table.Numbers("force_n"), (std::vector<double>{0.0, -1.25, 2.5})) << text;
}

TEST(CsvTable, TakesNamesOfColumnsFromACommentRightBeforeTheRows) {
  ExpectCurve("# needle 18 G\n# time_s force_n\n0 0\n0.5 -1.25\n1 2.5\n");  // NumPy's savetxt.
  ExpectCurve("# time_s,force_n\n0 0\n0.5 -1.25\n1 2.5\n");
  ExpectCurve("% Time (ms)\tForce (mN)\n0\t0\n500\t-1250\n1000\t2500\n");
  ExpectCurve("//Time [s];Force [N]\n0;0\n0,5;-1,25\n1;2,5\n");
  ExpectCurve("# two columns\ntime_s,force_n\n0,0\n0.5,-1.25\n1,2.5\n");
  EXPECT_THAT([] { CsvTable(FileWith("# measured today by A\n0,0\n0.5,1\n1,2\n")); },
              ThrowsMessage<InputError>(HasSubstr(":2: begins with numbers")));
}

TEST(CsvTable, ReadsWhatProgramsAndMachinesWrite) {
  ExpectCurve("\xEF\xBB\xBFtime_s,force_n\r\n0,0\r\n0.5,-1.25\r\n1,2.5");
  ExpectCurve("time_s;force_n\n0;0\n0,5;-1,25\n1,0;2,5\n");
  ExpectCurve("time_s\tforce_n\n0\t0\n0,5\t-1,25\n1\t2,5\n");
  ExpectCurve("time_s force_n\n 0   0\n 0.5 -1.25 \n1 +2.5\n");
  ExpectCurve("time_s  force_n\n0,0 0,0\n0,5 -1,25\n1,0 2,5\n");
  ExpectCurve("\"time_s\",\"force_n\"\n\"0\",\"0\"\n\"0,5\",\"-1,25\"\n\"1,0\",\"2,5\"\n");
  ExpectCurve("Time (ms),Force [mN]\n0,0\n500,-1250\n1000,2500\n");
  ExpectCurve("Time,Force\n(s),(kN)\n0,0\n0.5,-0.00125\n1,0.0025\n");
  ExpectCurve("Specimen,A1\nDate,2024\n\nTime,Force,Note\ns,N,\n0,0,\n0.5,-1.25,\n1,2.5,\n");
  ExpectCurve(
      "\"Specimen label\",\"P1\"\n\"Rate 1\",\"120.0\",\"mm/min\"\n\n\"Time\",\"Force\",\"Note\"\n"
      "\"(s)\",\"(N)\",\"\"\n\"0\",\"0\",\"\"\n\"0.5\",\"-1.25\",\"\"\n\"1\",\"2.5\",\"\"\n");
  ExpectCurve("% a\n// b\nTIME_S|FORCE_N\n0|0\n0.5|-1.25\n1|2.5\n||\n");
  std::string wide = "\xFF\xFE";
  for (const char c : std::string("time_s;force_n\n0;0\n0,5;-1,25\n1;2,5\n")) {
    wide += {c, '\0'};
  }
  ExpectCurve(wide);
}

TEST(CsvTable, TakesUnitsAndColumnsOfASidecarAsBidsHasThem) {
  const testing_support::TemporaryFolder folder;
  const auto table = [&](std::string_view text, std::string_view sidecar) {
    WriteTextFile(folder / "push.tsv", text);
    WriteTextFile(folder / "push.json", sidecar);
    return CsvTable(folder / "push.tsv");
  };
  const CsvTable units = table("time\tforce\n0\t0\n500\t-1250\n1000\t2500\n",
                               R"({"time": {"Units": "ms"}, "force": {"Units": "mN"}})");
  EXPECT_EQ(units.Numbers("time_s"), (std::vector<double>{0.0, 0.5, 1.0}));
  EXPECT_EQ(units.Numbers("force_n"), (std::vector<double>{0.0, -1.25, 2.5}));
  EXPECT_THAT(units.how_read(), HasSubstr("units as in push.json"));
  const CsvTable rows = table("0\t1\n-1.25\t1\n2.5\t1\n",
                              R"({"Columns": ["force", "trigger"], "force": {"Units": "N"},
                                  "SamplingFrequency": 2, "StartTime": -3.5})");
  EXPECT_EQ(rows.Numbers("time_s"), (std::vector<double>{-3.5, -3.0, -2.5}));
  EXPECT_EQ(rows.Numbers("force_n"), (std::vector<double>{0.0, -1.25, 2.5}));
  for (const char* sidecar : {"[]", "{", R"({"Columns": "force"})", R"({"StartTime": "now"})",
                              R"({"SamplingFrequency": 0})", R"({"time": {"Units": 3}})"}) {
    EXPECT_THAT([&] { table("time\tforce\n0\t0\n", sidecar); },
                ThrowsMessage<InputError>(HasSubstr("push.json: ")))
        << sidecar;
  }
  // A table that has another name does not take it.
  WriteTextFile(folder / "push.csv", "time\tforce\n0\t0\n");
  EXPECT_THAT([&] { CsvTable(folder / "push.csv").Numbers("time_s"); },
              ThrowsMessage<InputError>(HasSubstr("does not say its unit")));
}

TEST(CsvTable, NamesAFileThatIsCompressed) {
  EXPECT_THAT([] { CsvTable(FileWith("\x1F\x8B\x08")); },
              ThrowsMessage<InputError>(HasSubstr("compressed by gzip")));
}

TEST(CsvTable, SaysWhatItTook) {
  CsvTable table(FileWith("Weg\na;b\nTime [s];Load_kN\n0,5;1\n1,5;\n2,5;3\n"));
  constexpr std::string_view kForce[] = {"load"};
  table.Accept("force_n", kForce);
  EXPECT_EQ(table.Taken("force_n"), "force_n from 'Load_kN'");
  EXPECT_THAT(table.how_read(), HasSubstr("semicolons between cells, decimal comma"));
  EXPECT_THAT(table.how_read(), HasSubstr("2 rows before it skipped"));
  constexpr std::string_view kNeeded[] = {"force_n"};
  EXPECT_EQ(table.DropRowsWithout(kNeeded), 1U);
  EXPECT_EQ(table.Numbers("force_n"), (std::vector<double>{1000.0, 3000.0}));
  EXPECT_EQ(table.Where(1), table.path().string() + ":6");
}

TEST(CsvTable, RefusesWhatHasTwoReadings) {
  const auto message = [](std::string_view text) {
    return [text] { CsvTable(FileWith(text)).Numbers("force_n"); };
  };
  EXPECT_THAT(message("time_s,force_n\n0,5,1,5\n"),
              ThrowsMessage<InputError>(HasSubstr("a comma may separate cells or decimals")));
  EXPECT_THAT(message("time_s;force_n\n0.5;1,5\n"),
              ThrowsMessage<InputError>(HasSubstr("the numbers '0.5' and '1,5'")));
  EXPECT_THAT(message("time_s,Force\n0,1\n"),
              ThrowsMessage<InputError>(HasSubstr("'Force' does not say its unit")));
  EXPECT_THAT(message("Force [N],force_kn\n0,1\n"),
              ThrowsMessage<InputError>(HasSubstr("may be column 'Force [N]' or 'force_kn'")));
}

TEST(NumberText, ReadsBackAsTheSameBits) {
  for (const double value : {0.1, -1e-300, 1.0 / 3.0, 123456789.123456789}) {
    EXPECT_EQ(std::stod(NumberText(value)), value);
  }
}

}  // namespace
}  // namespace acus
