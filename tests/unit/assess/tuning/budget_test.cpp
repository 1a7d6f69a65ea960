#include "acus/assess/tuning/budget.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/assess/tuning/budget_scenario.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "support/temporary_folder.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Knob NodesKnob() {
  Knob knob;
  knob.name = "needle_nodes";
  knob.pointers = {"/effects/needle/nodes"};
  knob.acts_on = ActsOn::kForce;
  knob.values = {15, 25, 50};
  knob.scenario_value = 25;
  return knob;
}

Knob PlanesKnob() {
  Knob knob;
  knob.name = "elevation_planes";
  knob.pointers = {"/effects/ultrasound/beams/elevation_planes"};
  knob.acts_on = ActsOn::kImage;
  knob.values = {1, 3};
  knob.scenario_value = 3;
  return knob;
}

/// As if it had been measured.
MeasuredSetting AsMeasured(ValueIndices indices, double step_us, double image_ms, double error_n,
                           double db) {
  MeasuredSetting out;
  out.indices = std::move(indices);
  out.cost = {.step_us_median = 0.2 * step_us,
              .step_us_p999 = step_us,
              .image_ms_median = 0.9 * image_ms,
              .image_ms_p95 = image_ms};
  out.force_rms_n = error_n;
  out.image_psnr_db = db;
  out.image_ssim = 0.97;
  out.stages = {
      {"needle shape", "step", 0.9}, {"B-mode", "image", 0.8}, {"CT slice", "image", 0.2}};
  Measured run;
  run.step_us_p999 = step_us;
  run.image_ms_p95 = image_ms;
  run.force_rms_n = error_n;
  out.runs = {run};
  return out;
}

/// Given 25 nodes and 3 planes; chosen 50 nodes and 1 plane.
class Budget : public testing::Test {
 protected:
  void SetUp() override {
    setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
    fs::create_directories(folder_ / "given");
    WriteTextFile(folder_ / "given" / "ct.nrrd", "");
    WriteTextFile(folder_ / "given" / "labels.seg.nrrd", "");
    WriteTextFile(folder_ / "given" / "scene.json", R"({"format": "acus-scenario/1",
      "name": "Bending", "patient": {"ct": "ct.nrrd", "labels": "labels.seg.nrrd"},
      "effects": {"needle_force": {}, "needle": {"model": "bendable"},
                  "ultrasound": {"model": "beams", "beams": {"elevation_planes": 3}}}})");
    answer_.question = {.goal = ParseBudget("force=0.5ms,image=16ms"),
                        .asked = "--budget force=0.5ms,image=16ms"};
    answer_.plan.knobs = {NodesKnob(), PlanesKnob()};
    answer_.plan.request.scene.scenario = folder_ / "given" / "scene.json";
    answer_.plan.request.scene.session = "sessions/insertion";
    answer_.plan.request.repetitions = 1;
    answer_.plan.seconds = 6.0;
    const std::vector<MeasuredSetting> settings = {
        AsMeasured({1, 1}, 100.0, 20.0, 0.02, 60.0), AsMeasured({0, 1}, 60.0, 20.0, 0.05, 60.0),
        AsMeasured({2, 1}, 200.0, 20.0, 0.0, 60.0), AsMeasured({1, 0}, 100.0, 8.0, 0.02, 30.0),
        AsMeasured({2, 0}, 210.0, 8.2, 0.001, 30.0)};
    for (const MeasuredSetting& setting : settings) {
      Candidate candidate{.indices = setting.indices, .measured = {}, .predicted = {}};
      candidate.predicted.step_us = 205.0;
      candidate.predicted.image_ms = 8.0;
      answer_.choice.measured.push_back(candidate);
    }
    answer_.measured = settings;
    answer_.choice.num_one_at_a_time = 4;
    answer_.choice.chosen = 4;
    answer_.most_expensive = AsMeasured({2, 1}, 200.0, 20.0, 0.0, INFINITY);
  }

  testing_support::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
  BudgetAnswer answer_;
};

TEST_F(Budget, SaysWhatWasChosenWhatItTakesAndWhereTheTimeGoes) {
  const std::string text = AnswerText(answer_);
  EXPECT_THAT(text, HasSubstr("Chosen for force=0.5ms,image=16ms among 5 settings measured: "
                              "needle_nodes 50 instead of 25, elevation_planes 1 instead of 3."));
  EXPECT_THAT(text, HasSubstr("It takes 0.21 ms of 0.5 ms per force step (99.9th percentile) and "
                              "8.2 ms of 16 ms per image (95th percentile)"));
  EXPECT_THAT(
      text,
      HasSubstr("against the most expensive setting: 0.001 N RMS of force and 30 dB of PSNR"));
  EXPECT_THAT(text, HasSubstr("The scenario as it was takes 0.1 ms of 0.5 ms"));
  EXPECT_THAT(text, HasSubstr("Of a force step needle shape takes 90 %."));
  EXPECT_THAT(text, HasSubstr("Of an image B-mode takes 80 %, CT slice 20 %."));
  EXPECT_THAT(text,
              HasSubstr("The most expensive knob of a force step is needle_nodes: 50 instead of 15 "
                        "takes 0.14 ms more."));
}

TEST_F(Budget, SaysWhatTheCheapestTakesIfNothingFits) {
  answer_.choice.chosen.reset();
  answer_.choice.nearest = 3;
  const std::string text = AnswerText(answer_);
  EXPECT_THAT(text, AllOf(HasSubstr("None of the 5 settings measured fits force=0.5ms,image=16ms. "
                                    "The cheapest (elevation_planes 1 instead of 3) takes 0.1 ms"),
                          HasSubstr("Of an image B-mode takes 80 %"), Not(HasSubstr("Chosen"))));
}

TEST_F(Budget, AnswersForALiveSessionInOneWord) {
  answer_.question.live = true;
  EXPECT_THAT(AnswerText(answer_),
              AllOf(HasSubstr("No, this machine does not run the scene live as it is: 0.1 ms of "
                              "0.5 ms per force step"),
                    HasSubstr("It would with needle_nodes 50 instead of 25, elevation_planes 1")));
  answer_.choice.chosen = 0;
  EXPECT_THAT(AnswerText(answer_), HasSubstr("Yes, this machine runs the scene live: 0.1 ms of"));
}

TEST_F(Budget, ChosenScenarioIsFoundFromAnywhereWithItsEvidence) {
  fs::create_directories(folder_ / "result");
  WriteChosenScenario(folder_ / "result" / "scenario.json", answer_);
  fs::create_directories(folder_ / "moved");
  fs::rename(folder_ / "result" / "scenario.json", folder_ / "moved" / "scenario.json");
  const auto chosen = scenario::ReadScenario(folder_ / "moved" / "scenario.json", {});
  EXPECT_EQ(chosen.name, "Bending");
  EXPECT_EQ(chosen.patient.ct, folder_ / "given" / "ct.nrrd");
  EXPECT_EQ(chosen.shape->nodes, 50);
  EXPECT_EQ(chosen.ultrasound->beams.at("elevation_planes"), 1);
  ASSERT_TRUE(chosen.evidence.has_value());
  EXPECT_EQ(chosen.evidence->asked, "--budget force=0.5ms,image=16ms");
  EXPECT_EQ(chosen.evidence->session, "insertion");
  EXPECT_EQ(chosen.evidence->settings_measured, 5);
  EXPECT_EQ(chosen.evidence->measured.step_us_p999, 210.0);
  EXPECT_EQ(chosen.evidence->predicted.step_us_p999, 205.0);
  EXPECT_EQ(chosen.evidence->stages.front().stage, "needle shape");
}

TEST_F(Budget, ResultReportsEachKnobByItself) {
  const SweepResult result = ResultOf(answer_);
  std::vector<std::string> told;
  for (const SettingResult& setting : result.settings) {
    told.push_back(setting.knob + ": " + TextOf(setting.setting));
  }
  EXPECT_THAT(told, testing::ElementsAre(
                        "needle_nodes: needle_nodes=15", "needle_nodes: needle_nodes=25",
                        "needle_nodes: needle_nodes=50", "elevation_planes: elevation_planes=1",
                        "elevation_planes: elevation_planes=3",
                        "jointly: elevation_planes=3, needle_nodes=25",
                        "jointly: elevation_planes=1, needle_nodes=50",
                        "jointly: elevation_planes=3, needle_nodes=50"));
}

}  // namespace
}  // namespace acus::tuning
