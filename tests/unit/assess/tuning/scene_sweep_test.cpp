#include "acus/assess/tuning/scene_sweep.h"

#include <cmath>
#include <gmock/gmock.h>
#include <thread>

#include "acus/assess/tuning/result_files.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/sweep_folder.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::kBendableEffects;

class SceneSweep : public testing_support::SweepFolder {};

/// All that must not depend on when and how a sweep was run.
std::string ErrorsOf(const SweepResult& result) {
  std::string text;
  for (const Measured& run : result.runs) {
    nlohmann::json line = ToJson(run);
    for (const char* time :
         {"step_us_median", "step_us_p999", "step_us_mean", "image_ms_median", "image_ms_p95",
          "image_ms_mean", "preparation_s", "memory_mb", "stages"}) {
      line.erase(time);
    }
    text += line.dump() + "\n";
  }
  return text;
}

TEST_F(SceneSweep, TheReferenceIsRightAndCoarserIsWorse) {
  Make(kBendableEffects);
  request_.knobs = {"needle_nodes=8,15,50"};
  request_.repetitions = 2;
  const SweepResult result = Sweep("a");
  ASSERT_EQ(result.settings.size(), 3U);
  const auto& finest = Of(result, {{"needle_nodes", 50}});
  EXPECT_TRUE(finest.is_reference);
  EXPECT_EQ(finest.force_rms_n.mean, 0.0);
  EXPECT_EQ(finest.force_largest_n.mean, 0.0);
  const auto& middle = Of(result, {{"needle_nodes", 15}});
  EXPECT_TRUE(middle.is_scenario);
  EXPECT_TRUE(middle.is_paper);
  EXPECT_GT(middle.force_rms_n.mean, 0.0);
  EXPECT_EQ(middle.force_rms_n.half_width, 0.0);  // The same in both repetitions.
  EXPECT_GT(Of(result, {{"needle_nodes", 8}}).force_rms_n.mean, middle.force_rms_n.mean);
  EXPECT_LT(middle.force_rms_n.mean, 1.0);
  EXPECT_GT(finest.step_us_median.mean, middle.step_us_median.mean);
  EXPECT_GT(finest.step_us_over_scenario.mean, 0.0);
  EXPECT_TRUE(std::isnan(finest.image_ms_median.mean));
  EXPECT_EQ(finest.unusable, "");
  double share = 0.0;
  for (const StageShare& stage : result.runs.front().stages) share += stage.share;
  EXPECT_NEAR(share, 1.0, 1e-9);
  EXPECT_THAT(Sentences(result), HasSubstr("needle_nodes 15 instead of 50: force "));
}

TEST_F(SceneSweep, ARateOfStepsMakesSoManySteps) {
  Make(R"({"needle_force": {}})");
  request_.knobs = {"step_rate_hz=500,1000,2000"};
  const SweepResult result = Sweep("a");
  for (const Measured& run : result.runs) {
    EXPECT_EQ(run.steps, run.setting.at("step_rate_hz").get<int>() + 1);
  }
  EXPECT_GT(Of(result, {{"step_rate_hz", 500}}).force_rms_n.mean,
            Of(result, {{"step_rate_hz", 1000}}).force_rms_n.mean);
}

TEST_F(SceneSweep, OnlyTheChosenSecondsCount) {
  Make(R"({"needle_force": {}})");
  request_.knobs = {"step_rate_hz=500,1000"};
  request_.scene.from_s = 0.4;
  request_.scene.to_s = 0.7;
  for (const Measured& run : Sweep("a").runs) {
    EXPECT_EQ(run.steps, 0.3 * run.setting.at("step_rate_hz").get<double>() + 1);
  }
}

TEST_F(SceneSweep, KnobsOfTheImageChangeTheImageAlone) {
  Make(R"({"needle_force": {}, "ultrasound": {"model": "beams"}})");
  request_.knobs = {"elevation_planes=1,5", "speckle", "point_spread"};
  const SweepResult result = Sweep("a");
  for (const SettingResult& setting : result.settings) {
    EXPECT_EQ(setting.force_rms_n.mean, 0.0) << TextOf(setting.setting);
    if (setting.is_reference) {
      EXPECT_EQ(setting.image_rms_grey.mean, 0.0);
      EXPECT_TRUE(std::isinf(setting.image_psnr_db.mean));
      EXPECT_EQ(setting.image_ssim.mean, 1.0);
    } else {
      EXPECT_GT(setting.image_rms_grey.mean, 0.5) << TextOf(setting.setting);
      EXPECT_LT(setting.image_ssim.mean, 0.999) << TextOf(setting.setting);
    }
  }
  EXPECT_GT(Of(result, {{"elevation_planes", 5}}).image_ms_median.mean,
            1.5 * Of(result, {{"elevation_planes", 1}}).image_ms_median.mean);
  EXPECT_EQ(result.runs.front().images, 2);
}

TEST_F(SceneSweep, LinesSamplesAndInversionsReachTheImage) {
  Make(R"({"needle_force": {}, "tissue": {"model": "displacement_functions"},
           "ultrasound": {"model": "beams", "beams": {"speckle": false}}})");
  request_.knobs = {"image_lines=64,256", "image_samples=256,1024", "tissue_warp_spacing_mm=8,1",
                    "tissue_inverse_iterations=1,12"};
  const SweepResult result = Sweep("a");
  for (const Measured& run : result.runs) {
    EXPECT_EQ(run.image_rms_grey == 0.0, run.is_reference) << TextOf(run.setting);
  }
  // The defaults are those of the preset: naming them changes nothing.
  const auto knobs = KnobsOf(scenario::ReadScenario(folder_ / "scene.json", {}), 0.0);
  const Knob& lines = KnobNamed(knobs, "image_lines");
  const auto plain = RunSetting(Plan(), {}, 0, context_);
  const auto named = RunSetting(Plan(), {{"image_lines", lines.default_value}}, 0, context_);
  EXPECT_EQ(plain.series.pixels, named.series.pixels);
}

// What is random in a scene is another in each repetition, and the same in all settings.
TEST_F(SceneSweep, RepetitionsDrawAgainAndPairTheirSeeds) {
  Make(R"({"ultrasound": {"model": "beams"}})");
  request_.knobs = {"elevation_planes=1,3", "point_spread=off,on"};
  request_.repetitions = 2;
  const SweepPlan plan = Plan();
  const auto first = RunSetting(plan, {}, 0, context_);
  EXPECT_NE(first.series.pixels, RunSetting(plan, {}, 1, context_).series.pixels);
  EXPECT_EQ(first.series.pixels, RunSetting(plan, {}, 0, context_).series.pixels);
  const SweepResult result = Sweep("a");
  const auto& coarse = Of(result, {{"elevation_planes", 1}});
  EXPECT_GT(coarse.image_rms_grey.half_width, 0.0);
  // Each repetition has a reference of its own.
  EXPECT_EQ(Of(result, {{"elevation_planes", 3}}).image_rms_grey.mean, 0.0);
  for (const Measured& run : result.runs) {
    EXPECT_EQ(run.seed, static_cast<std::uint64_t>(run.repetition));
  }
}

TEST_F(SceneSweep, TakenUpAgainTheErrorsAreTheSame) {
  Make(kBendableEffects);
  request_.knobs = {"needle_nodes=8,15,50", "needle_path_spacing_mm=4,1"};
  const SweepResult whole = Sweep("whole");

  // Stopped in the third run.
  const SweepPlan plan = Plan();
  const RunStore store(folder_ / "part", IdentityOf(plan), false);
  std::atomic<bool> stop{false};
  RunContext stopping;
  stopping.stop = &stop;
  stopping.on_progress = [&](std::string_view, double) {
    if (ProgressOf(plan, store).done == 2) stop = true;
  };
  EXPECT_THROW(RunCases(plan, store, "", stopping), Cancelled);
  EXPECT_EQ(ProgressOf(plan, store).done, 2);
  EXPECT_THAT([&] { Collect(plan, store); },
              ThrowsMessage<InputError>(HasSubstr("3 of 5 runs are missing")));
  // A run that was cut off, and a reference that has rotted.
  const fs::path cut = folder_ / "part/runs" / (plan.cases[1].name + ".json");
  fs::resize_file(cut, fs::file_size(cut) / 2);
  const fs::path rotten = store.ReferenceFile(plan.cases[0].reference);
  std::string bytes = ReadTextFile(rotten);
  bytes[bytes.size() / 2] ^= 4;
  WriteTextFile(rotten, bytes);
  const std::string kept = ReadTextFile(folder_ / "part/runs" / (plan.cases[0].name + ".json"));
  const SweepResult taken_up = Sweep("part");
  EXPECT_EQ(ErrorsOf(taken_up), ErrorsOf(whole));
  EXPECT_EQ(taken_up.runs.size(), 5U);
  EXPECT_FALSE(kept.empty());
}

TEST_F(SceneSweep, SeveralAtOnceAndCaseByCaseGiveTheSameErrors) {
  Make(kBendableEffects);
  request_.knobs = {"needle_nodes=8,15,50"};
  const SweepResult serial = Sweep("serial");
  const SweepPlan plan = Plan();
  const auto identity = IdentityOf(plan);
  const auto run_all = [&](const char* name) {
    RunContext context;
    RunCases(plan, RunStore(folder_ / name, identity, false), "", context);
  };
  std::thread other(run_all, "both");
  run_all("both");
  other.join();
  EXPECT_EQ(ErrorsOf(Collect(plan, RunStore(folder_ / "both", identity, false))), ErrorsOf(serial));

  // The last one first: it needs a reference that nobody has made.
  const RunStore store(folder_ / "single", identity, false);
  for (auto one = plan.cases.rbegin(); one != plan.cases.rend(); ++one) {
    RunCases(plan, store, one->name, context_);
  }
  EXPECT_EQ(ErrorsOf(Collect(plan, store)), ErrorsOf(serial));
  EXPECT_THAT([&] { RunCases(plan, store, "needle_nodes-16-r0", context_); },
              ThrowsMessage<InputError>(HasSubstr("did you mean needle_nodes-15-r0?")));
}

TEST_F(SceneSweep, JointlyAllAreComparedWithTheMostExpensive) {
  Make(kBendableEffects);
  request_.knobs = {"needle_nodes=8,50", "needle_path_spacing_mm=4,1"};
  request_.jointly = true;
  const SweepResult result = Sweep("a");
  ASSERT_EQ(result.settings.size(), 4U);
  EXPECT_TRUE(result.settings.back().is_reference);
  EXPECT_EQ(result.settings.back().force_rms_n.mean, 0.0);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_GT(result.settings[i].force_rms_n.mean, 0.0);
}

TEST_F(SceneSweep, FilesSayTheSameAsTheResult) {
  Make(R"({"needle_force": {}})");
  request_.knobs = {"step_rate_hz=500,1000"};
  const SweepResult result = Sweep("a");
  WriteResult(folder_ / "a", result, context_);
  const auto json = nlohmann::json::parse(ReadTextFile(folder_ / "a/tradeoff.json"));
  EXPECT_EQ(json.at("runs").size(), 2U);
  EXPECT_EQ(json.at("settings").at(0).at("force_rms_n").at("mean"),
            result.settings.front().force_rms_n.mean);
  const std::string csv = ReadTextFile(folder_ / "a/tradeoff.csv");
  EXPECT_EQ(std::ranges::count(csv, '\n'), 3);
  EXPECT_THAT(csv, HasSubstr("step_rate_hz,step_rate_hz=500,1,0,0,0,0,"));
  EXPECT_THAT(TableText(result), HasSubstr("scenario, Augmented-2010; Vidal-2008, reference"));
}

}  // namespace
}  // namespace acus::tuning
