#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "stability_page/stability_report.h"
#include "support/bound.h"
#include "support/temporary_folder.h"

namespace acus::stability_page {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

json Record(const std::string& test, const std::string& quantity, double measured, bool holds) {
  return {{"kind", "bound"}, {"module", "needle"},   {"suite", "Rod"},
          {"test", test},    {"file", "f.cpp"},      {"hard", "It <bends>."},
          {"unit", "mm"},    {"quantity", quantity}, {"sense", "<="},
          {"bound", 2.0},    {"measured", measured}, {"holds", holds}};
}

class StabilityPageTest : public testing::Test {
 protected:
  void Bounds(const std::vector<json>& records) {
    std::string lines;
    for (const json& record : records) lines += record.dump() + "\n";
    std::filesystem::create_directories(folder_ / "bounds");
    WriteTextFile(folder_ / "bounds/needle.jsonl", lines);
  }
  void Programs(const std::string& lines) { WriteTextFile(folder_ / "programs.jsonl", lines); }
  void Tests(const json& test) {
    std::filesystem::create_directories(folder_ / "tests");
    const json suite = {{"name", "Rod"}, {"testsuite", json::array({test})}};
    const json all = {{"testsuites", json::array({suite})}};
    WriteTextFile(folder_ / "tests/stability_needle.json", all.dump());
  }
  StabilityRun Read() const { return ReadStabilityRun(folder_.path()); }

  testing_support::TemporaryFolder folder_;
};

TEST_F(StabilityPageTest, AValueHasAMarginAndItsTestAName) {
  Bounds({Record("TurnedBy180DegreesIt1", "error", 0.5, true)});
  const StabilityRun run = Read();
  ASSERT_EQ(run.values.size(), 1u);
  EXPECT_EQ(run.values[0].Margin(), 4.0);
  EXPECT_EQ(run.values[0].origin.Name(), "Turned by 180 degrees it 1");
  EXPECT_TRUE(run.AllHold());
  const std::string page = StabilityPage(run, {});
  EXPECT_THAT(page, HasSubstr("It &lt;bends&gt;."));
  EXPECT_THAT(page, HasSubstr("≤ 2 mm"));
  EXPECT_THAT(page, HasSubstr("4 x"));
  EXPECT_THAT(page, Not(HasSubstr("What fails")));
}

TEST_F(StabilityPageTest, TestsOfOneNameAreDistinguishedByTheirSuites) {
  json other = Record("StandsStill/2", "error", 0.5, true);
  other["suite"] = "RodInTissue/1";
  Bounds({Record("StandsStill", "error", 0.5, true), other, Record("Other", "error", 0.5, true)});
  const StabilityRun run = Read();
  EXPECT_EQ(run.values.at(0).origin.Name(), "Stands still (Rod)");
  EXPECT_EQ(run.values.at(1).origin.Name(), "Stands still (Rod in tissue)");
  EXPECT_EQ(run.values.at(2).origin.Name(), "Other");
}

TEST_F(StabilityPageTest, MarginsOfLeastValuesEqualitiesAndZero) {
  BoundedValue value;
  value.sense = ">=";
  value.bound = 2.0;
  value.measured = 6.0;
  value.holds = true;
  EXPECT_EQ(value.Margin(), 3.0);
  value.sense = "==";
  EXPECT_EQ(value.Margin(), 1.0);
  value.sense = "<=";
  value.measured = 0.0;
  EXPECT_EQ(value.Margin(), HUGE_VAL);
}

TEST_F(StabilityPageTest, WhatFailsStandsFirst) {
  Bounds({Record("Good", "small", 0.5, true), Record("Bad", "large", 3.0, false)});
  const StabilityRun run = Read();
  EXPECT_FALSE(run.AllHold());
  ASSERT_EQ(run.Failing().size(), 1u);
  EXPECT_EQ(run.Failing()[0]->quantity, "large");
  const std::string page = StabilityPage(run, {});
  EXPECT_LT(page.find("What fails"), page.find("small"));
  EXPECT_THAT(page, HasSubstr("FAILS"));
  const json out = StabilityJson(run, {});
  EXPECT_EQ(out["all_hold"], false);
  EXPECT_EQ(out["values"][1]["holds"], false);
}

// A number that is none is null in JSON, and fails.
TEST_F(StabilityPageTest, WhatIsNoNumberIsSaidToBeNone) {
  json record = Record("Bad", "force", 0.0, false);
  record["measured"] = nullptr;
  Bounds({record});
  const StabilityRun run = Read();
  EXPECT_TRUE(std::isnan(run.values[0].measured));
  EXPECT_THAT(StabilityPage(run, {}), HasSubstr("not a number"));
  EXPECT_TRUE(StabilityJson(run, {})["values"][0]["measured"].is_null());
}

TEST_F(StabilityPageTest, OfAValueStatedTwiceTheFailingOneStays) {
  Bounds({Record("T", "q", 3.0, false), Record("T", "q", 0.5, true)});
  EXPECT_FALSE(Read().values.at(0).holds);
  Bounds({Record("T", "q", 0.5, true), Record("T", "q", 1.5, true)});
  const StabilityRun run = Read();
  ASSERT_EQ(run.values.size(), 1u);
  EXPECT_EQ(run.values[0].measured, 1.5);
}

TEST_F(StabilityPageTest, AFailedTestAndACrashFailThePageWithoutAnyValue) {
  Bounds({Record("T", "q", 0.5, true)});
  Tests({{"name", "Other"},
         {"time", "0.5s"},
         {"failures", json::array({{{"failure", "energy from nowhere"}}})}});
  Programs(
      "{\"program\": \"stability_needle\", \"exit_code\": 1, \"seconds\": 2.5}\n"
      "{\"program\": \"stability_forces\", \"exit_code\": 139, \"seconds\": 1}\n");
  const StabilityRun run = Read();
  EXPECT_FALSE(run.AllHold());
  EXPECT_EQ(run.FailedTests().size(), 1u);
  ASSERT_EQ(run.Crashed().size(), 1u);  // The other one's test says why.
  EXPECT_EQ(run.Crashed()[0]->program, "stability_forces");
  const std::string page = StabilityPage(run, {});
  EXPECT_THAT(page, HasSubstr("energy from nowhere"));
  EXPECT_THAT(page, HasSubstr("139"));
}

TEST_F(StabilityPageTest, PlotsLeaveOutWhatCannotBeDrawn) {
  json plot = Record("T", "q", 0.5, true);
  plot.update(
      {{"kind", "plot"},
       {"title", "Residual"},
       {"x_label", "step"},
       {"y_label", "r [N]"},
       {"log_x", false},
       {"log_y", true},
       {"curves", {{{"name", "a"}, {"x", {0, 1, 2, 3}}, {"y", {1.0, 0.0, nullptr, 2.0}}}}}});
  Bounds({Record("T", "q", 0.5, true), plot});
  const StabilityRun run = Read();
  ASSERT_EQ(run.plots.size(), 1u);
  EXPECT_THAT(run.plots[0].plot.series[0].x, testing::ElementsAre(0.0, 3.0));
  EXPECT_THAT(StabilityPage(run, {}), HasSubstr("<svg"));
}

TEST_F(StabilityPageTest, TheTableForTheDocumentation) {
  json record = Record("ALongHold", "a|b", 0.5, true);
  Bounds({record});
  const std::string table = StabilityTable(Read(), {});
  EXPECT_THAT(table, HasSubstr("| **A long hold** It <bends>. | a\\|b | 0.5 mm | ≤ 2 mm | 4 x |"));
}

TEST_F(StabilityPageTest, BrokenRecordsAreNamed) {
  EXPECT_THAT([this] { Read(); }, ThrowsMessage<InputError>(HasSubstr("developer/stability")));
  std::filesystem::create_directories(folder_ / "bounds");
  WriteTextFile(folder_ / "bounds/needle.jsonl",
                Record("T", "q", 0.5, true).dump() + "\n{\"kind\": \"bound\"");
  EXPECT_THAT([this] { Read(); }, ThrowsMessage<InputError>(HasSubstr("needle.jsonl:2")));
  Bounds({Record("T", "q", 0.5, true)});
  std::filesystem::create_directories(folder_ / "tests");
  WriteTextFile(folder_ / "tests/a.json", "[1, 2]");
  EXPECT_THAT([this] { Read(); }, ThrowsMessage<InputError>(HasSubstr("a.json")));
}

TEST_F(StabilityPageTest, FilesAreWritten) {
  Bounds({Record("T", "q", 0.5, true)});
  WriteStability(folder_.path(), Read(), {});
  EXPECT_THAT(ReadTextFile(folder_ / "stability.html"), HasSubstr("<html"));
  EXPECT_EQ(json::parse(ReadTextFile(folder_ / "stability.json"))["format"], "acus-stability/1");
}

TEST(StabilityMachine, IsNamed) {
  EXPECT_THAT(MachineText(), HasSubstr(" cores, "));
}

}  // namespace
}  // namespace acus::stability_page
