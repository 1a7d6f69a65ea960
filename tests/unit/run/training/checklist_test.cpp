#include "acus/run/training/checklist.h"

#include <cmath>
#include <gtest/gtest.h>

namespace acus::training {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(Checklist, TicksInOrderAndKeepsTicks) {
  ChecklistMeter meter({.in_order = true,
                        .steps = {{"probe", StepCondition::kProbeOnSkin, 0.5, "press"},
                                  {"needle", StepCondition::kNeedleInTissue, 0.0, ""},
                                  {"out", StepCondition::kNeedleWithdrawn, 0.0, ""}}});
  Situation now;
  now.needle_seen = true;
  now.needle_in_tissue = true;
  now.tip_mm = Eigen::Vector3d(0, 0, 1);
  meter.Add(1 * kSecond, now, false);
  EXPECT_EQ(NextStep(meter.results()), 0U) << "a step waits for those before it";
  now.probe_on_skin = true;
  now.tip_mm = Eigen::Vector3d(0, 0, 6);
  meter.Add(2 * kSecond, now, false);
  EXPECT_EQ(meter.results()[0].state, StepState::kOpen) << "contact has to last";
  meter.Add(2 * kSecond + kSecond / 2, now, false);
  EXPECT_EQ(meter.results()[0].state, StepState::kDone);
  EXPECT_EQ(meter.results()[0].time_ns, 2 * kSecond + kSecond / 2);
  EXPECT_EQ(meter.results()[1].state, StepState::kDone);
  now.probe_on_skin = now.needle_in_tissue = false;
  meter.Add(4 * kSecond, now, false);
  EXPECT_EQ(meter.results()[0].state, StepState::kDone);
  EXPECT_EQ(meter.results()[2].state, StepState::kDone);
  EXPECT_FALSE(NextStep(meter.results()).has_value());
}

TEST(Checklist, AConditionThatBreaksStartsAgain) {
  ChecklistMeter meter({.steps = {{"probe", StepCondition::kProbeOnSkin, 1.0, ""}}});
  Situation on;
  on.probe_on_skin = true;
  meter.Add(1 * kSecond, on, false);
  meter.Add(kSecond + kSecond / 2, {}, false);
  meter.Add(2 * kSecond, on, false);
  EXPECT_EQ(meter.results()[0].state, StepState::kOpen);
  meter.Add(3 * kSecond, on, false);
  EXPECT_EQ(meter.results()[0].state, StepState::kDone);
}

TEST(Checklist, TremorAtTheSkinIsNoWithdrawal) {
  ChecklistMeter meter({.steps = {{"out", StepCondition::kNeedleWithdrawn, 0.0, ""},
                                  {"spare", StepCondition::kStructuresSpared, 0.0, ""}}});
  const auto add = [&meter](double z_mm) {
    Situation now;
    now.needle_seen = true;
    now.needle_in_tissue = z_mm > 0.0;
    now.tip_mm = Eigen::Vector3d(0, 0, z_mm);
    meter.Add(kSecond, now, false);
  };
  for (int i = 0; i < 50; ++i) add(i % 2 == 0 ? 0.3 : -0.3);
  add(1.5);
  add(-1.0);
  EXPECT_EQ(NextStep(meter.results()), 0U);
  EXPECT_EQ(meter.results()[1].state, StepState::kOpen);
  add(8.0);
  add(-1.0);
  EXPECT_FALSE(NextStep(meter.results()).has_value());
}

TEST(Checklist, StructuresAreSparedOnlyToTheEnd) {
  ChecklistMeter meter({.steps = {{"spare", StepCondition::kStructuresSpared, 0.0, ""},
                                  {"reach", StepCondition::kTargetReached, 0.0, ""}}});
  Situation now;
  now.needle_seen = true;
  now.needle_in_tissue = now.target_reached = true;
  meter.Add(1 * kSecond, now, false);
  EXPECT_EQ(meter.results()[0].state, StepState::kDone);
  EXPECT_EQ(meter.results()[1].state, StepState::kDone) << "what is spared holds up no other step";
  meter.Add(2 * kSecond, now, true);
  EXPECT_EQ(meter.results()[0].state, StepState::kFailed);
  EXPECT_EQ(meter.results()[0].time_ns, 2 * kSecond);
}

TEST(Checklist, ANeedleThatIsMovedToAndFroInTheImageIsJiggled) {
  const auto done = [](double amplitude_mm, bool in_plane, double advance_mm_s) {
    ChecklistMeter meter({.steps = {{"jiggle", StepCondition::kNeedleJiggled, 0.0, ""}}});
    Situation now;
    now.needle_seen = now.needle_in_tissue = true;
    now.needle_in_plane = in_plane;
    for (int i = 0; i < 400; ++i) {  // 4 s at 100 Hz, a stroke each half second.
      const double t = 0.01 * i;
      now.tip_mm =
          Eigen::Vector3d(3.0, amplitude_mm * std::sin(2.0 * M_PI * t), 20.0 + advance_mm_s * t);
      meter.Add(static_cast<std::int64_t>(t * 1e9), now, false);
    }
    return meter.results()[0].state == StepState::kDone;
  };
  EXPECT_TRUE(done(2.0, true, 0.0));
  EXPECT_TRUE(done(2.0, true, 5.0));
  EXPECT_FALSE(done(0.3, true, 0.0)) << "tremor";
  EXPECT_FALSE(done(0.0, true, 20.0)) << "an advance";
  EXPECT_FALSE(done(2.0, false, 0.0)) << "not in the image";
}

TEST(Checklist, SlowStrokesAreNoJiggle) {
  ChecklistMeter meter({.steps = {{"jiggle", StepCondition::kNeedleJiggled, 0.0, ""}}});
  Situation now;
  now.needle_seen = now.needle_in_tissue = now.needle_in_plane = true;
  for (int i = 0; i < 3000; ++i) {
    now.tip_mm = Eigen::Vector3d(0.0, 5.0 * std::sin(2.0 * M_PI * 0.01 * i / 6.0), 0.0);
    meter.Add(i * kSecond / 100, now, false);
  }
  EXPECT_EQ(meter.results()[0].state, StepState::kOpen);
}

TEST(Checklist, ThePositionIsCheckedInAHeldBreath) {
  ChecklistMeter meter({.steps = {{"skin", StepCondition::kNeedleAtSkin, 0.0, ""},
                                  {"check", StepCondition::kPositionChecked, 1.0, ""}}});
  Situation now;
  now.needle_seen = now.needle_at_skin = true;
  meter.Add(kSecond, now, false);
  EXPECT_EQ(meter.results()[0].state, StepState::kDone);
  now.needle_at_skin = false;
  now.needle_in_tissue = now.target_reached = now.needle_in_plane = now.target_in_view = true;
  for (int s = 2; s < 5; ++s) meter.Add(s * kSecond, now, false);
  EXPECT_EQ(meter.results()[1].state, StepState::kOpen) << "breathing";
  now.breath_held = true;
  meter.Add(5 * kSecond, now, false);
  now.needle_in_plane = false;
  meter.Add(6 * kSecond, now, false);
  EXPECT_EQ(meter.results()[1].state, StepState::kOpen) << "out of the image";
  now.needle_in_plane = true;
  meter.Add(7 * kSecond, now, false);
  meter.Add(8 * kSecond, now, false);
  EXPECT_EQ(meter.results()[1].state, StepState::kDone);
}

TEST(Checklist, APlungerIsPressedOrPulledInTissue) {
  ChecklistMeter meter({.steps = {{"press", StepCondition::kPlungerPressed, 0.0, ""},
                                  {"pull", StepCondition::kPlungerPulled, 0.0, ""}}});
  const auto add = [&meter](bool in_tissue, double plunger_n) {
    Situation now;
    now.needle_seen = true;
    now.needle_in_tissue = in_tissue;
    now.plunger_n = plunger_n;
    meter.Add(kSecond, now, false);
  };
  add(false, 5.0);
  add(false, -5.0);
  add(true, 0.9);
  add(true, -0.9);
  EXPECT_EQ(NextStep(meter.results()), 0U) << "outside, or too gently";
  add(true, 1.0);
  EXPECT_EQ(NextStep(meter.results()), 1U);
  add(true, -1.0);
  EXPECT_FALSE(NextStep(meter.results()).has_value());
}

TEST(Checklist, HintsFadeWithTrials) {
  const HintOptions hints{.trials = 3, .wait_s = 10.0};
  EXPECT_TRUE(ShowsHint(hints, 1, 0.0));
  EXPECT_FALSE(ShowsHint(hints, 2, 9.0));
  EXPECT_TRUE(ShowsHint(hints, 2, 10.0));
  EXPECT_FALSE(ShowsHint(hints, 3, 19.0));
  EXPECT_TRUE(ShowsHint(hints, 3, 20.0));
  EXPECT_FALSE(ShowsHint(hints, 4, 1000.0));
}

TEST(Checklist, WordsOfExerciseFiles) {
  for (int i = 0; i <= static_cast<int>(StepCondition::kPlungerPulled); ++i) {
    const auto condition = static_cast<StepCondition>(i);
    EXPECT_EQ(StepConditionOf(NameOf(condition)), condition);
  }
  EXPECT_FALSE(StepConditionOf("probe").has_value());
}

}  // namespace
}  // namespace acus::training
