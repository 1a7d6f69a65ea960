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
  EXPECT_THAT(TextsOf(LinesToShow(frame, {})),
              testing::ElementsAre("Failed: Spare bone.",
                                   "No step remains: press Q twice to end the session."));
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

TEST(LinesToShow, WhatToDoNowIsTheNextStepWhereNothingIsInTheWay) {
  DisplayFrame frame;
  frame.exercise.emplace();
  frame.exercise->steps = {{"Place the probe", StepState::kDone},
                           {"Puncture the skin", StepState::kOpen}};
  frame.exercise->next_step = 1;
  EXPECT_THAT(TextsOf(LinesToShow(frame, {})), testing::ElementsAre("Next: Puncture the skin."));
  frame.exercise->how = "Page Down advances the needle.";
  EXPECT_THAT(TextsOf(LinesToShow(frame, {})),
              testing::ElementsAre("Next: Puncture the skin. Page Down advances the needle."));
  frame.coach = "Slide the probe.";
  EXPECT_THAT(TextsOf(LinesToShow(frame, {})), testing::ElementsAre("Slide the probe."));
  frame.coach.clear();
  frame.exercise->next_step.reset();
  frame.exercise->steps[1].state = StepState::kFailed;
  EXPECT_THAT(TextsOf(LinesToShow(frame, {})),
              testing::ElementsAre("Failed: Puncture the skin.",
                                   "No step remains: press Q twice to end the session."));
  frame.exercise->steps[1].state = StepState::kDone;
  EXPECT_THAT(TextsOf(LinesToShow(frame, {})),
              testing::ElementsAre("All steps are done: press Q twice to end the session."));
}

TEST(StatusBar, FiguresForEngineersNeedAKey) {
  const FontAtlas atlas;
  DisplayFrame frame;
  frame.latency = {.device_to_force_ms = 0.3, .tracker_to_image_ms = 48.0, .images_per_s = 30.0};
  frame.force = {.needle_n = 1.0, .probe_n = 2.0, .limit_n = 5.0};
  const auto letters = [&](const ViewChoice& choice) {
    Sketch sketch(atlas);
    DrawStatusBar(frame, choice, std::nullopt, {.left = 0, .top = 0, .width = 1280, .height = 106},
                  SizesFor(800), sketch);
    return sketch.vertices();
  };
  ViewChoice with_figures;
  with_figures.figures = true;
  EXPECT_GT(letters(with_figures).size(), letters({}).size() + 4 * 40);
  // The trainee's bar does not depend on them.
  const auto before = letters({});
  frame.latency = {.device_to_force_ms = 9.9, .tracker_to_image_ms = 1.0, .images_per_s = 3.0};
  const auto after = letters({});
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].u, after[i].u);
    EXPECT_EQ(before[i].x, after[i].x);
  }
}

}  // namespace
}  // namespace acus::window
