#include "acus/run/training/checklist.h"

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
  meter.Add(1 * kSecond, now, false);
  EXPECT_EQ(NextStep(meter.results()), 0U) << "a step waits for those before it";
  now.probe_on_skin = true;
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
  for (int i = 0; i <= static_cast<int>(StepCondition::kStructuresSpared); ++i) {
    const auto condition = static_cast<StepCondition>(i);
    EXPECT_EQ(StepConditionOf(NameOf(condition)), condition);
  }
  EXPECT_FALSE(StepConditionOf("probe").has_value());
}

}  // namespace
}  // namespace acus::training
