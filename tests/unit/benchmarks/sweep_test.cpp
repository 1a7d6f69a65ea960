#include "benchmarks/sweep.h"

#include <fstream>
#include <gmock/gmock.h>
#include <sstream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "benchmarks/tissue_run.h"
#include "benchmarks/tradeoff_report.h"
#include "support/temporary_folder.h"

namespace acus::benchmarks {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(Sweeps, AreFoundByName) {
  EXPECT_EQ(SweepNamed("tissue").name, "tissue");
  EXPECT_THAT([] { SweepNamed("tissues"); },
              ThrowsMessage<InputError>(HasSubstr(
                  "there is no sweep 'tissues'; there are: tissue, strain, needle, forces")));
}

std::vector<Row> TwoRows() {
  Row good;
  good.knob = "size_mm";
  good.value = "4";
  good.model = "model, fine";  // A comma in a text.
  good.error = 0.25;
  good.error_unit = "N";
  good.reference = "finest";
  good.step_us_median = 3.0;
  good.step_us_p999 = 30.0;
  good.preparation_s = 2.0;
  good.memory_mb = 7.5;
  good.is_default = true;
  Row bad = good;
  bad.value = "8";
  bad.preparation_s = kNotMeasured;
  bad.is_default = false;
  bad.unusable = "a force of 99 N";
  return {good, bad};
}

Sweep Fake(std::vector<Row> rows) {
  return {"fake", "A fake", "Nothing was done.", [rows](bool, const RunContext&) { return rows; }};
}

TEST(SweepToFolder, WritesRowsOnceInEveryForm) {
  const testing_support::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  SweepToFolder(Fake(TwoRows()), true, out, {});
  const CsvTable csv(out / "tradeoff.csv");
  EXPECT_EQ(csv.num_rows(), 2U);
  EXPECT_EQ(csv.Numbers("error"), (std::vector<double>{0.25, 0.25}));
  EXPECT_EQ(csv.Numbers("is_default"), (std::vector<double>{1.0, 0.0}));
  EXPECT_EQ(csv.Texts("model")[0], "model; fine");
  EXPECT_EQ(csv.Texts("preparation_s")[1], "");
  EXPECT_EQ(csv.Texts("unusable")[1], "a force of 99 N");
  const auto json = config::ReadJson(out / "tradeoff.json");
  EXPECT_EQ(json.at("rows").at(0).at("memory_mb"), 7.5);
  EXPECT_TRUE(json.at("rows").at(1).at("preparation_s").is_null());
  std::ifstream html(out / "tradeoff.html");
  std::stringstream text;
  text << html.rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("must not be used: a force of 99 N"));
  EXPECT_TRUE(std::filesystem::exists(out / "tradeoff.svg"));
  EXPECT_TRUE(std::filesystem::exists(out / "provenance.json"));
}

TEST(SweepToFolder, SaysNoIfNothingCanBeUsed) {
  const testing_support::TemporaryFolder folder;
  std::vector<Row> rows = TwoRows();
  rows.erase(rows.begin());
  EXPECT_THAT([&] { SweepToFolder(Fake(rows), true, folder.path() / "out", {}); },
              ThrowsMessage<NoAnswerError>(HasSubstr("no setting can be used")));
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
}

TEST(TissueSweep, StopsOnRequest) {
  std::atomic<bool> stop{true};
  RunContext context;
  context.stop = &stop;
  EXPECT_THROW(SweepNamed("tissue").run(true, context), Cancelled);
}

class TissueRuns : public testing::Test {
 protected:
  Provenance provenance_;
  TissueBlockTables tables_ = TissueBlockTables::FromPresets(provenance_);
  std::vector<tissue::ToolSample> samples_ = ScriptedInsertion();
};

TEST_F(TissueRuns, OfEveryModelMayBeUsed) {
  const double largest_n = tables_.forces.settings.largest_force_n;
  FemSetting coarse;
  coarse.element_mm = 6.0;
  const MeasuredRun fem = RunFem(coarse, tables_, samples_, {});
  EXPECT_EQ(WhyUnusable(fem.run, samples_, largest_n), "");
  EXPECT_GT(fem.memory_mb, 0.5);
  EXPECT_GT(fem.preparation_s, 0.01);
  EXPECT_GT(fem.num_nodes, 4000);
  EXPECT_EQ(WhyUnusable(RunPlane(6.0, 90.0, 84.0, tables_, samples_).run, samples_, largest_n), "");
  EXPECT_EQ(WhyUnusable(RunSprings(2.0, tables_, samples_).run, samples_, largest_n), "");
  EXPECT_EQ(WhyUnusable(RunRigid(tables_, samples_).run, samples_, largest_n), "");
}

TEST_F(TissueRuns, FloatStorageChangesForcesByLessThan1e8NWhilePressing) {
  FemSetting setting;
  setting.element_mm = 6.0;
  const MeasuredRun twice = RunFem(setting, tables_, samples_, {});
  setting.storage = mechanics::Storage::kFloat;
  const MeasuredRun single = RunFem(setting, tables_, samples_, {});
  // Later a point can begin to slip a sample earlier or later, which is a difference of its own.
  std::size_t n = 0;
  double largest_n = 0.0;
  for (; samples_[n].tip_in_ct_mm[2] > -10.0; ++n) {
    largest_n = std::max(largest_n, (single.run.force_n[n] - twice.run.force_n[n]).norm());
  }
  ASSERT_GT(twice.run.force_n[n].norm(), 0.5);
  EXPECT_GT(largest_n, 0.0);
  EXPECT_LT(largest_n, 1e-8);
  EXPECT_NEAR(single.memory_mb, 0.5 * twice.memory_mb, 1e-12);
}

TEST_F(TissueRuns, DimplesComeToTheClosedFormWithFinerElements) {
  const auto error = [&](double element_mm, mechanics::ElementKind kind) {
    return DimpleErrorPercent(element_mm, kind, tables_, {});
  };
  const double coarse = error(12.0, mechanics::ElementKind::kAveragedDilatation);
  const double fine = error(4.0, mechanics::ElementKind::kAveragedDilatation);
  EXPECT_LT(fine, 0.5 * coarse);
  EXPECT_LT(fine, 3.0);
  EXPECT_GT(error(4.0, mechanics::ElementKind::kLinear), 3.0 * fine);  // Locking at nu 0.49.
}

}  // namespace
}  // namespace acus::benchmarks
