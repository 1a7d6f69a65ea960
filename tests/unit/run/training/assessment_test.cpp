#include "acus/run/training/assessment.h"

#include <fstream>
#include <gmock/gmock.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/run/training/progress.h"
#include "acus/run/training/score.h"
#include "support/fuzz.h"
#include "support/temporary_folder.h"

namespace acus::training {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::TemporaryFolder;

std::filesystem::path Written(const TemporaryFolder& folder, const std::string& text) {
  const auto path = folder.path() / "exercise.json";
  WriteTextFile(path, text);
  return path;
}

constexpr const char* kExercise = R"({
  "format": "acus-exercise/1", "name": "Biopsy",
  "target": {"file": "target.csv", "radius_mm": 4}, "avoid": ["vessel"],
  "passes": {"redirection_deg": 6},
  "goals": [{"metric": "attempts", "at_most": 1},
            {"metric": "needle in the image plane", "at_least": 50, "at_most": 90, "why": "look"}]})";

TEST(Exercise, ReadsWhatItSays) {
  const TemporaryFolder folder;
  const Exercise exercise = ReadExercise(Written(folder, kExercise));
  EXPECT_EQ(exercise.name, "Biopsy");
  EXPECT_EQ(exercise.target_file, folder.path() / "target.csv");
  EXPECT_EQ(exercise.target_radius_mm, 4.0);
  EXPECT_NEAR(exercise.passes.redirection_rad, 0.10471975511965977, 1e-15);
  EXPECT_EQ(exercise.passes.turn_mm, PassOptions{}.turn_mm) << "the schema's default";
  EXPECT_EQ(exercise.image_plane.shaft_mm, PlaneOptions{}.shaft_mm);
  EXPECT_EQ(exercise.image_plane.half_thickness_mm, PlaneOptions{}.half_thickness_mm);
  ASSERT_EQ(exercise.goals.size(), 2);
  EXPECT_EQ(exercise.goals[1].at_least, 50.0);
}

TEST(Exercise, DefaultsOfTheSchemaAreThoseOfTheCode) {
  const TemporaryFolder folder;
  const Exercise exercise =
      ReadExercise(Written(folder, R"({"format": "acus-exercise/1", "name": "x"})"));
  EXPECT_NEAR(exercise.passes.redirection_rad, PassOptions{}.redirection_rad, 1e-15);
  EXPECT_EQ(exercise.passes.withdrawal_mm, PassOptions{}.withdrawal_mm);
  EXPECT_EQ(exercise.target_radius_mm, Exercise{}.target_radius_mm);
  EXPECT_EQ(exercise.target_point, Exercise{}.target_point);
}

TEST(Exercise, ReadsChecklistAndHints) {
  const TemporaryFolder folder;
  const Exercise exercise = ReadExercise(Written(folder, R"({
    "format": "acus-exercise/1", "name": "x", "target": {"name": "L3/L4"},
    "checklist": {"order": "free", "steps": [
      {"text": "Probe", "when": "probe_on_skin", "for_s": 0.5, "hint": "press"},
      {"text": "Reach", "when": "target_reached"}]},
    "hints": {"trials": 2}})"));
  EXPECT_EQ(exercise.target_name, "L3/L4");
  EXPECT_FALSE(exercise.checklist.in_order);
  ASSERT_EQ(exercise.checklist.steps.size(), 2U);
  EXPECT_EQ(exercise.checklist.steps[0].for_s, 0.5);
  EXPECT_EQ(exercise.checklist.steps[1].when, StepCondition::kTargetReached);
  EXPECT_EQ(exercise.hints.trials, 2);
  EXPECT_EQ(exercise.hints.wait_s, HintOptions{}.wait_s);
  EXPECT_THAT(
      [&] {
        ReadExercise(Written(folder, R"({"format": "acus-exercise/1", "name": "x",
          "checklist": {"steps": [{"text": "a", "when": "probe_on_skn"}]}})"));
      },
      ThrowsMessage<InputError>(HasSubstr("probe_on_skn")));
}

TEST(Assessment, AnAttemptInTheAirMeetsNoGoalOfTheNeedle) {
  const std::vector<Goal> goals = {{"attempts", 1.0, {}, ""},
                                   {"bone contacts", 0.0, {}, ""},
                                   {"largest probe force", 5.0, {}, ""}};
  std::vector<Metric> metrics = {{"passes", "", 0.0},
                                 {"attempts", "", 0.0},
                                 {"bone contacts", "", 0.0},
                                 {"largest probe force", "N", 2.0}};
  auto results = JudgeGoals(goals, metrics);
  EXPECT_FALSE(results[0].met || results[1].met);
  EXPECT_FALSE(results[0].value.has_value());
  EXPECT_TRUE(results[2].met);
  Assessment assessment;
  assessment.metrics = metrics;
  EXPECT_THAT(OutcomeText(assessment), HasSubstr("No insertion"));
  assessment.goals = results;
  EXPECT_FALSE(IsJudged(assessment, results[0]));
  EXPECT_TRUE(IsJudged(assessment, results[2]));
  EXPECT_THAT(GoalsText(assessment), testing::Not(HasSubstr("not met"))) << "that is said once";
  assessment.goals.clear();
  metrics[0].value = 1.0;
  results = JudgeGoals(goals, metrics);
  EXPECT_TRUE(results[0].met && results[1].met);
  assessment.metrics = metrics;
  assessment.metrics.push_back({"tip to target at the end", "mm", 2.0});
  assessment.target = "L3/L4";
  assessment.target_radius_mm = 3.0;
  EXPECT_EQ(OutcomeText(assessment),
            "Target reached: the tip ended 2 mm from L3/L4 (at most 3 mm).");
}

TEST(Exercise, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  const auto reading = [&](const std::string& goals) {
    return [&folder, goals] {
      ReadExercise(Written(
          folder, R"({"format": "acus-exercise/1", "name": "x", "goals": [)" + goals + "]}"));
    };
  };
  EXPECT_THAT(reading(R"({"metric": "attempts", "why": "x"})"),
              ThrowsMessage<InputError>(HasSubstr("/goals/0: has no limit")));
  EXPECT_THAT(reading(R"({"metric": "a", "at_least": 2, "at_most": 1})"),
              ThrowsMessage<InputError>(HasSubstr("at_least 2 lies above at_most 1")));
  EXPECT_THAT(reading(R"({"metric": "a", "at_most": 2}, {"metric": "a", "at_most": 1})"),
              ThrowsMessage<InputError>(HasSubstr("has a goal already")));
  EXPECT_THAT(reading(R"({"metrik": "a", "at_most": 2})"),
              ThrowsMessage<InputError>(HasSubstr("metrik")));
}

TEST(Goals, AreHeldAgainstMetrics) {
  const std::vector<Metric> metrics = {{"attempts", "", 1.0}, {"share", "%", 95.0}};
  const auto results = JudgeGoals({{"attempts", 1.0, {}, ""}, {"share", 90.0, 50.0, ""}}, metrics);
  ASSERT_EQ(results.size(), 2);
  EXPECT_TRUE(results[0].met);
  EXPECT_FALSE(results[1].met);
  EXPECT_EQ(GoalText(results[1].goal, "%"), "at least 50 %, at most 90 %");
  EXPECT_THAT(
      [&] {
        JudgeGoals({{"atempts", 1.0, {}, ""}}, metrics);
      },
      ThrowsMessage<InputError>(AllOf(HasSubstr("atempts"), HasSubstr("attempts, share"))));
}

TEST(Goals, ATargetThatWasNotReachedIsAGoalNotMet) {
  const Goal goal{kTimeToTarget, 10.0, {}, ""};
  const std::vector<Metric> missed = {{"tip to target, closest", "mm", 9.0}};
  const auto results = JudgeGoals({goal}, missed);
  ASSERT_EQ(results.size(), 1);
  EXPECT_FALSE(results[0].met);
  EXPECT_FALSE(results[0].value.has_value());
  EXPECT_THROW(JudgeGoals({goal}, {}), InputError) << "there was no target at all";
}

Assessment Example(const std::string& trainee, double attempts) {
  Assessment assessment;
  assessment.exercise = "Biopsy";
  assessment.trainee = trainee;
  assessment.session = "session";
  assessment.metrics = {{"attempts", "", attempts}, {"time", "s", 12.5}};
  assessment.goals = JudgeGoals({{"attempts", 1.0, {}, "it hurts", 2.0, true}}, assessment.metrics);
  assessment.structures = {{"vessel", {11, 2, 3.5, 1'500'000'000}}};
  return assessment;
}

// 20 mm beside the target, and all other goals met: a trial of every exercise with a target fails.
TEST(Assessment, AMissOfTheTargetFailsTheTrial) {
  int exercises = 0;
  for (const auto& entry :
       std::filesystem::directory_iterator(ACUS_SOURCE_DIR "/configs/exercises")) {
    const Exercise exercise = ReadExercise(entry.path());
    const auto metric = [](const Goal& goal) { return goal.metric; };
    if (std::ranges::find(exercise.goals, "tip to target at the end", metric) ==
        exercise.goals.end()) {
      continue;  // An epidural puncture ends where the resistance is lost.
    }
    Assessment trial;
    for (const Goal& goal : exercise.goals) {
      const bool is_target = goal.metric == "tip to target at the end";
      EXPECT_EQ(goal.must, is_target) << entry.path() << goal.metric;
      trial.metrics.push_back(
          {goal.metric, "mm",
           is_target ? 20.0 : goal.at_most.value_or(goal.at_least.value_or(0.0))});
    }
    trial.goals = JudgeGoals(exercise.goals, trial.metrics);
    EXPECT_EQ(trial.NumMet() + 1, trial.goals.size()) << entry.path();
    EXPECT_FALSE(trial.Passed()) << entry.path();
    EXPECT_LT(ScoreOf(trial), 0.25) << entry.path();
    EXPECT_THAT(GoalsText(trial), HasSubstr("Failed: tip to target at the end: 20 mm, required"));
    EXPECT_EQ(ToJson(trial).at("passed"), false);
    ++exercises;
  }
  EXPECT_EQ(exercises, 6);
}

TEST(Exercise, SaysItselfWhatIsAMust) {
  const TemporaryFolder folder;
  const auto goals = ReadExercise(Written(folder, R"({"format": "acus-exercise/1", "name": "x",
      "goals": [{"metric": "attempts", "at_most": 1, "must": true, "weight": 2.5},
                {"metric": "tip to target at the end", "at_most": 3, "must": false},
                {"metric": "tip to target, closest", "at_most": 3}]})"))
                         .goals;
  EXPECT_TRUE(goals[0].must);
  EXPECT_EQ(goals[0].weight, 2.5);
  EXPECT_FALSE(goals[1].must);
  EXPECT_EQ(goals[1].weight, Goal{}.weight);
  EXPECT_TRUE(goals[2].must);
}

TEST(Assessment, ReadsBackAsWritten) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "training.json";
  config::WriteJson(path, ToJson(Example("A7", 2.0)));
  EXPECT_EQ(ToJson(ReadAssessment(path)), ToJson(Example("A7", 2.0)));
}

TEST(Assessment, SurvivesDamagedFiles) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "training.json";
  const std::string text = ToJson(Example("A7", 2.0)).dump(2);
  const int refused =
      testing_support::ReadDamagedCopies(text, path, 300, [&] { ReadAssessment(path); });
  EXPECT_GT(refused, 100);
}

TEST(Assessment, RefusesNumbersThatNoIntegerHolds) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "training.json";
  for (const int entries : {0, std::numeric_limits<int>::max()}) {
    auto document = ToJson(Example("A7", 2.0));
    document["structures"][0]["entries"] = entries;
    config::WriteJson(path, document);
    EXPECT_EQ(ReadAssessment(path).structures[0].entered.num_entries, entries);
  }
  for (const char* key : {"label", "entries", "first_time_s"}) {
    auto document = ToJson(Example("A7", 2.0));
    document["structures"][0][key] = 1e300;
    config::WriteJson(path, document);
    EXPECT_THAT([&] { ReadAssessment(path); },
                ThrowsMessage<InputError>(
                    AllOf(HasSubstr("training.json: "), HasSubstr(key), HasSubstr("1e+300"))));
  }
  auto document = ToJson(Example("A7", 2.0));
  document["checklist"] = {{{"text", "Scan"}, {"state", "done"}, {"time_s", -1e300}}};
  config::WriteJson(path, document);
  EXPECT_THAT([&] { ReadAssessment(path); }, ThrowsMessage<InputError>(HasSubstr("time_s: is")));
}

void WriteRun(const std::filesystem::path& run, const Assessment& assessment) {
  std::filesystem::create_directories(run);
  config::WriteJson(run / "training.json", ToJson(assessment));
}

TEST(Progress, PutsSessionsSideBySide) {
  const TemporaryFolder folder;
  const std::vector<std::filesystem::path> runs = {folder.path() / "1", folder.path() / "2",
                                                   folder.path() / "3"};
  WriteRun(runs[0], Example("A7", 3.0));
  WriteRun(runs[1], Example("B2", 2.0));
  WriteRun(runs[2], Example("A7", 1.0));
  const auto sessions = ReadAssessments(runs);
  EXPECT_THAT(ProgressText(sessions), HasSubstr("3 !"));
  RunContext context;
  WriteProgress(folder.path(), sessions, context);
  const CsvTable table(folder.path() / "progress.csv");
  EXPECT_THAT(table.Texts("trainee"), testing::ElementsAre("A7", "B2", "A7"));
  EXPECT_THAT(table.Numbers("attempts"), testing::ElementsAre(3.0, 2.0, 1.0));
  EXPECT_THAT(table.Numbers("goals_met"), testing::ElementsAre(0.0, 0.0, 1.0));
  EXPECT_THAT(ReadTextFile(folder.path() / "progress.html"), HasSubstr("it hurts"));
}

TEST(Progress, RefusesWhatCannotBeCompared) {
  const TemporaryFolder folder;
  const std::vector<std::filesystem::path> runs = {folder.path() / "1", folder.path() / "2"};
  std::filesystem::create_directories(runs[1]);
  WriteRun(runs[0], Example("A7", 3.0));
  EXPECT_THAT([&] { ReadAssessments(runs); },
              ThrowsMessage<InputError>(HasSubstr("acus-replay --exercise")));
  Assessment other = Example("A7", 1.0);
  other.exercise = "Puncture";
  WriteRun(runs[1], other);
  EXPECT_THAT([&] { ReadAssessments(runs); }, ThrowsMessage<InputError>(HasSubstr("Puncture")));
  other = Example("A7", 1.0);
  other.goals.clear();
  WriteRun(runs[1], other);
  EXPECT_THAT([&] { ReadAssessments(runs); }, ThrowsMessage<InputError>(HasSubstr("other goals")));
}

}  // namespace
}  // namespace acus::training
