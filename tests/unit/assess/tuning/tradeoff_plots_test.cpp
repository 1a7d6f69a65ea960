#include "acus/assess/tuning/tradeoff_plots.h"

#include <gmock/gmock.h>
#include <limits>

#include "acus/assess/tuning/tradeoff_page.h"
#include "acus/base/core/atomic_file.h"
#include "support/temporary_folder.h"

namespace acus::tuning {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

SettingResult NodesSetting(int nodes, double step_us, double error_n) {
  SettingResult setting;
  setting.knob = "needle_nodes";
  setting.setting = {{"needle_nodes", nodes}};
  setting.step_us_median = {step_us, 0.5, 3};
  setting.step_us_p999 = {4.0 * step_us, 2.0, 3};
  setting.force_felt_n = {1.0, 0.1, 3};
  setting.force_rms_n = {error_n, 0.1 * error_n, 3};
  return setting;
}

/// 100 is the reference; 8 is more expensive and worse than 15; 50 must not be used.
SweepResult Nodes() {
  SweepResult result;
  result.scenario = "Bending & <steering>";
  result.machine = "Some processor, 8 threads";
  result.repetitions = 3;
  Knob knob;
  knob.name = "needle_nodes";
  knob.title = "nodes of the bendable needle";
  knob.papers = {{25, "Fortmeier-2016"}};
  result.knobs = {knob};
  result.settings = {NodesSetting(8, 12, 0.1), NodesSetting(15, 10, 0.05),
                     NodesSetting(25, 20, 0.02), NodesSetting(50, 1, 0.0001),
                     NodesSetting(100, 80, 0.0)};
  result.settings[2].is_default = result.settings[2].is_paper = true;
  result.settings[2].paper = "Fortmeier-2016";
  result.settings[3].unusable = "it gave the hand 5 mJ more than it took";
  result.settings[4].is_reference = true;
  return result;
}

const report::Series* Named(const report::Plot& plot, const std::string& name) {
  for (const report::Series& series : plot.series) {
    if (series.name == name) return &series;
  }
  return nullptr;
}

TEST(TradeoffPlots, ShowUsableSettingsWithIntervalsFrontAndMarks) {
  const auto plots = TradeoffPlots(Nodes(), {});
  ASSERT_EQ(plots.size(), 1U);  // No images.
  const report::Plot& plot = plots.front();
  EXPECT_TRUE(plot.log_x && plot.log_y);
  const report::Series* dots = Named(plot, "needle_nodes");
  ASSERT_NE(dots, nullptr);
  EXPECT_THAT(dots->x, ElementsAre(12, 10, 20));
  EXPECT_THAT(dots->labels, ElementsAre("8", "15", "25"));
  EXPECT_DOUBLE_EQ(dots->x_low[0], 11.5);
  EXPECT_DOUBLE_EQ(dots->high[1], 0.055);
  const report::Series* front = Named(plot, "");
  ASSERT_NE(front, nullptr);
  EXPECT_THAT(front->x, ElementsAre(10, 20));
  ASSERT_NE(Named(plot, "default"), nullptr);
  EXPECT_THAT(Named(plot, "default")->x, ElementsAre(20));
  EXPECT_THAT(Named(plot, "paper")->x, ElementsAre(20));
  EXPECT_TRUE(plot.marks.empty());
}

TEST(TradeoffPlots, WithABudgetShowItsPercentileItsLineAndTheChosen) {
  PlotRemarks remarks;
  remarks.goal = ParseBudget("force=0.06ms");
  remarks.chosen = Setting{{"needle_nodes", 15}};
  const auto plots = TradeoffPlots(Nodes(), remarks);
  ASSERT_EQ(plots.size(), 1U);
  EXPECT_THAT(Named(plots[0], "needle_nodes")->x, ElementsAre(48, 40, 80));
  ASSERT_EQ(plots[0].marks.size(), 1U);
  EXPECT_DOUBLE_EQ(plots[0].marks[0].x, 60.0);
  EXPECT_TRUE(plots[0].marks[0].widens);
  EXPECT_THAT(Named(plots[0], "chosen")->x, ElementsAre(40));
  EXPECT_THAT(Named(plots[0], "Pareto front")->x, ElementsAre(40, 80));
}

TEST(TradeoffPlots, OfImagesMorePsnrIsBetter) {
  SweepResult result = Nodes();
  const double dbs[] = {30, 35, 34, 50, std::numeric_limits<double>::infinity()};
  const double costs[] = {5, 6, 7, 1, 20};
  for (std::size_t i = 0; i < 5; ++i) {
    result.settings[i].image_ms_median = {costs[i], 0.1, 3};
    result.settings[i].image_psnr_db = {dbs[i], 1.0, 3};
    result.settings[i].image_ssim = {1.0 - 1.0 / dbs[i], 0.001, 3};
  }
  const auto plots = TradeoffPlots(result, {});
  ASSERT_EQ(plots.size(), 3U);
  EXPECT_FALSE(plots[1].log_y);
  EXPECT_THAT(Named(plots[1], "needle_nodes")->y, ElementsAre(30, 35, 34));
  EXPECT_THAT(Named(plots[1], "")->y, ElementsAre(30, 35));
  EXPECT_NEAR(Named(plots[2], "needle_nodes")->y[0], 1.0 / 30.0, 1e-12);
}

TEST(TradeoffPage, OpensFromDiskAndHasEverything) {
  const testing_support::TemporaryFolder temporary;
  RunContext context;
  PageContent content;
  content.answer = {"Chosen: 15."};
  content.remarks = {"Omitted: force_model=tissue"};
  WritePage(temporary.path(), Nodes(), content, context);
  const std::string html = ReadTextFile(temporary.path() / "tradeoff.html");
  for (const char* text :
       {"Bending &amp; &lt;steering&gt;", "Some processor, 8 threads", "Chosen: 15.",
        "needle_nodes 25 instead of 100", "Omitted: force_model=tissue", "must not be used",
        "nodes of the bendable needle", "25: Fortmeier-2016.", "<svg", "Provenance"}) {
    EXPECT_THAT(html, HasSubstr(text));
  }
  EXPECT_EQ(html.find("src=\"http"), html.npos);
  EXPECT_LT(html.find("Chosen: 15."), html.rfind("What cheaper settings save and lose"));
  EXPECT_LT(html.rfind("What cheaper settings save and lose"), html.rfind("What was measured"));
  EXPECT_TRUE(std::filesystem::exists(temporary.path() / "savings.svg"));
  EXPECT_FALSE(std::filesystem::exists(temporary.path() / "force.svg")) << "knobs are apart";
  EXPECT_FALSE(std::filesystem::exists(temporary.path() / "psnr.svg"));
}

}  // namespace
}  // namespace acus::tuning
