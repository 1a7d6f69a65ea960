// What the window says of an exercise: one distance, and no contradiction.
#include "acus/window/exercise_panel.h"

#include <gmock/gmock.h>

#include "acus/window/status_bar.h"

namespace acus::window {
namespace {

using testing::HasSubstr;
using training::StepState;

replay::GoalNow GoalNow(const char* metric, double value, bool met) {
  replay::GoalNow goal;
  goal.result.goal.metric = metric;
  goal.result.goal.at_most = 3.0;
  goal.result.unit = "mm";
  goal.result.value = value;
  goal.result.met = met;
  return goal;
}

std::vector<std::string> TextsOf(const std::vector<StatusLine>& lines) {
  std::vector<std::string> texts;
  for (const StatusLine& line : lines) texts.push_back(line.text);
  return texts;
}

TEST(ExerciseToShow, DistancesOfOtherMomentsHaveNoNumber) {
  training::Exercise exercise;
  exercise.target_name = "the duct";
  exercise.target_radius_mm = 3.0;
  replay::ExerciseProgress progress;
  progress.goals = {GoalNow("tip to target, closest", 0.371, true),
                    GoalNow("tip to target at the end", 137.2, false),
                    GoalNow("needle path length", 12.0, false)};
  const ExerciseOnDisplay shown = ExerciseToShow(exercise, progress, 137.2, 1);
  ASSERT_EQ(shown.goals.size(), 3U);
  EXPECT_EQ(shown.goals[0].value, "met so far");
  EXPECT_EQ(shown.goals[1].value, "not yet");
  EXPECT_EQ(shown.goals[1].severity, Severity::kNote) << "nothing is wrong on the way";
  EXPECT_EQ(shown.goals[2].value, "12 mm");
  EXPECT_FALSE(shown.target_reached);
  EXPECT_TRUE(ExerciseToShow(exercise, progress, 2.9, 1).target_reached);
}

TEST(LinesToShow, NothingIsWellBesideAFailedStep) {
  DisplayFrame frame;
  EXPECT_THAT(TextsOf(LinesToShow(frame, {})), testing::ElementsAre("All is well."));
  frame.exercise.emplace();
  frame.exercise->steps = {{"Place the probe", StepState::kDone},
                           {"Spare bone", StepState::kFailed}};
  EXPECT_THAT(TextsOf(LinesToShow(frame, {})), testing::ElementsAre("Failed: Spare bone."));
}

TEST(LinesToShow, DangerComesBeforeAdvice) {
  DisplayFrame frame;
  frame.coach = "Slide the probe.";
  frame.status = {{Severity::kNote, "Images come from another computer."},
                  {Severity::kWarning, "5 steps were late."}};
  frame.exercise.emplace();
  frame.exercise->steps = {{"Spare bone", StepState::kFailed}};
  EXPECT_THAT(TextsOf(LinesToShow(frame, {})),
              testing::ElementsAre("Failed: Spare bone.", "5 steps were late.", "Slide the probe.",
                                   "Images come from another computer."));
}

}  // namespace
}  // namespace acus::window
