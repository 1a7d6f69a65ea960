#include "acus/assess/trials/what_if.h"

#include <gmock/gmock.h>
#include <numbers>

#include "acus/assess/trials/what_if_files.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/csv.h"
#include "acus/run/replay/replay.h"
#include "support/trial_folder.h"

namespace acus::trials {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kRad = std::numbers::pi / 180.0;

class WhatIfTest : public testing_support::TrialFolder {
 protected:
  WhatIfSettings Few() const {
    WhatIfSettings settings;
    settings.count = 60;
    settings.best = 2;
    return settings;
  }
};

TEST_F(WhatIfTest, FindsTheLineOfATrial) {
  const session::Session trial = Insertion();
  const TrialLine line = LineOfTrial(Loaded(trial), trial);
  EXPECT_NEAR((line.entry_ct_mm - Eigen::Vector3d(3.0, -5.0, 0.0)).norm(), 0.0, 1e-5);
  EXPECT_NEAR((line.axis_in_ct - TrialAxis()).norm(), 0.0, 1e-12);
  EXPECT_NEAR(line.depth_mm, 35.0, 1e-5);
  EXPECT_NEAR(line.speed_mm_per_s, 20.0, 0.05);
  EXPECT_NEAR((line.inward_in_ct - Eigen::Vector3d::UnitZ()).norm(), 0.0, 1e-6);
  EXPECT_NEAR((line.along_in_ct - Eigen::Vector3d::UnitY()).norm(), 0.0, 1e-6);
  EXPECT_GE(1e-9 * static_cast<double>(line.deepest_ns), 2.249);
}

TEST_F(WhatIfTest, AChangeIsWhatItSays) {
  const session::Session trial = Insertion();
  const TrialScene scene = Loaded(trial);
  const TrialLine line = LineOfTrial(scene, trial);
  const auto steeper =
      ChangedInsertion(scene, line, {.along_mm = 4.0, .steeper_rad = 10.0 * kRad}, Few());
  ASSERT_TRUE(steeper);
  EXPECT_NEAR(std::acos(steeper->axis_in_ct.z()), 30.0 * kRad, 1e-9) << "40 degrees, 10 steeper";
  EXPECT_NEAR(steeper->axis_in_ct.x(), 0.0, 1e-9);
  EXPECT_NEAR((steeper->entry_ct_mm - Eigen::Vector3d(3.0, -1.0, 0.0)).norm(), 0.0, 1e-5);
  EXPECT_THAT(ChangeText(line, steeper->change), "entry 4 mm towards the back, 10 degrees steeper");
  const auto sideways = ChangedInsertion(scene, line, {.sideways_rad = 5.0 * kRad}, Few());
  ASSERT_TRUE(sideways);
  EXPECT_NEAR(std::acos(sideways->axis_in_ct.dot(line.axis_in_ct)), 5.0 * kRad, 1e-9);
  EXPECT_NEAR(sideways->axis_in_ct.dot(line.across_in_ct), std::sin(5.0 * kRad), 1e-9);
  EXPECT_FALSE(ChangedInsertion(scene, line, {.steeper_rad = -49.0 * kRad}, Few()))
      << "flat on the skin";
}

TEST_F(WhatIfTest, AMotionBeginsAndEndsAtRestWithTheSpeedBetween) {
  constexpr double kStep = 1e-5;
  for (const double length_mm : {0.3, 5.0, 80.0}) {
    const double end_s = DurationOf(length_mm, 20.0, 0.1);
    EXPECT_EQ(DistanceAfter(0.0, length_mm, 20.0, 0.1), 0.0);
    EXPECT_EQ(DistanceAfter(end_s, length_mm, 20.0, 0.1), length_mm);
    EXPECT_NEAR(DistanceAfter(0.5 * end_s, length_mm, 20.0, 0.1), 0.5 * length_mm, 1e-9);
    double fastest = 0.0;
    for (double t = 0.0; t < end_s; t += 1e-3) {
      const double speed = (DistanceAfter(t + kStep, length_mm, 20.0, 0.1) -
                            DistanceAfter(t, length_mm, 20.0, 0.1)) /
                           kStep;
      EXPECT_GE(speed, 0.0);
      fastest = std::max(fastest, speed);
    }
    EXPECT_NEAR(fastest, length_mm > 2.0 ? 20.0 : std::sqrt(20.0 * length_mm / 0.1), 0.2);
  }
}

TEST_F(WhatIfTest, AimedAlternativesPassThroughTheTarget) {
  const session::Session trial = Insertion();
  const TrialScene scene = Loaded(trial);
  WhatIfSettings settings = Few();
  settings.aim_jitter_deg = settings.aim_jitter_mm = 0.0;
  const auto alternatives = MakeAlternatives(scene, LineOfTrial(scene, trial), settings, false, 3);
  int aimed = 0;
  for (const Alternative& a : alternatives) {
    if (!a.aimed) continue;
    ++aimed;
    // The skin is flat: the entry stays where it was aimed from.
    EXPECT_LT((a.entry_ct_mm + a.depth_mm * a.axis_in_ct - *scene.target_ct_mm).norm(), 1e-4);
  }
  EXPECT_GT(aimed, 5);
  EXPECT_EQ(alternatives.size(), 60U);
}

/// The promise of the page: an alternative is its session, replayed.
TEST_F(WhatIfTest, EachIsTheFullReplayOfItsSessionToTheBit) {
  const session::Session trial = Insertion();
  const TrialScene scene = Loaded(trial);
  const WhatIf what_if = RunWhatIf(scene, trial, Few(), context_);
  for (const std::size_t n : {0, 1, 17, 40, 59}) {
    const Outcome& outcome = what_if.outcomes[n];
    const auto path = folder_ / Message("session_", n);
    session::WriteSession(path, SessionOf(scene, trial, what_if.line, outcome.alternative, Few()),
                          context_);
    // With images, from the files.
    replay::ReplayOptions options;
    options.run_folder = folder_ / Message("run_", n);
    options.exercise = folder_ / "exercise.json";
    options.film = options.sequence = false;
    replay::ReplaySession(Scenario(), path, options, context_);
    const auto replayed = training::ReadAssessment(options.run_folder / "training.json");
    ASSERT_EQ(replayed.metrics.size(), outcome.result.assessment.metrics.size());
    for (std::size_t m = 0; m < replayed.metrics.size(); ++m) {
      EXPECT_EQ(replayed.metrics[m].value, outcome.result.assessment.metrics[m].value)
          << n << ": " << replayed.metrics[m].name;
    }
    const TrialResult again = RunTrial(scene, session::ReadSession(path, context_), context_);
    EXPECT_EQ(again.force_hash, outcome.result.force_hash) << n;
  }
}

TEST_F(WhatIfTest, ThreadsDoNotMatterAndTheSeedDoes) {
  const session::Session trial = Insertion();
  const TrialScene scene = Loaded(trial);
  const WhatIf one = RunWhatIf(scene, trial, Few(), context_);
  context_.num_threads = 3;
  const WhatIf three = RunWhatIf(scene, trial, Few(), context_);
  context_.seed = 1;
  const WhatIf other = RunWhatIf(scene, trial, Few(), context_);
  EXPECT_EQ(one.ranking, three.ranking);
  int different = 0;
  for (std::size_t n = 0; n < one.outcomes.size(); ++n) {
    EXPECT_EQ(one.outcomes[n].result.force_hash, three.outcomes[n].result.force_hash);
    EXPECT_EQ(one.outcomes[n].score, three.outcomes[n].score);
    if (one.outcomes[n].result.force_hash != other.outcomes[n].result.force_hash) ++different;
  }
  EXPECT_GE(different, 15) << "the random ones";
}

TEST_F(WhatIfTest, RanksByGoalsThenByDistanceAndNamesWhatIsMissed) {
  const session::Session trial = Insertion();
  const TrialScene scene = Loaded(trial);
  WhatIfSettings settings = Few();
  settings.count = 200;
  const WhatIf what_if = RunWhatIf(scene, trial, settings, context_);
  EXPECT_EQ(ValueOf(what_if.outcomes[0].result.assessment, "attempts"), 1.0);
  double last = 2.0;
  for (const std::size_t n : what_if.ranking) {
    EXPECT_LE(what_if.outcomes[n].score, last);
    last = what_if.outcomes[n].score;
  }
  const Outcome& best = what_if.outcomes[what_if.ranking.front()];
  EXPECT_EQ(best.score, 1.0);
  EXPECT_THAT(OutcomeText(what_if, best, scene.exercise.avoid),
              testing::AllOf(HasSubstr("mm from the target"), HasSubstr("4 of 4 goals met")));
}

TEST_F(WhatIfTest, WritesPageMapTableAndSessions) {
  const session::Session trial = Insertion();
  const TrialScene scene = Loaded(trial);
  const WhatIf what_if = RunWhatIf(scene, trial, Few(), context_);
  WriteWhatIf(folder_, scene, trial, what_if, Few(), context_);
  EXPECT_EQ(CsvTable(folder_ / "what_if.csv").num_rows(), 60U);
  const auto json = config::ReadJson(folder_ / "what_if.json");
  EXPECT_EQ(json.at("best").size(), 2U);
  // From the worst, dark, to the best, light.
  EXPECT_THAT(
      ReadTextFile(folder_ / "map.svg"),
      testing::AllOf(HasSubstr("10 mm"), HasSubstr("rgb(68,1,84)"), HasSubstr("rgb(253,231,37)")));
  EXPECT_THAT(ReadTextFile(folder_ / "what_if.html"),
              testing::AllOf(HasSubstr(">best 2<"), testing::Not(HasSubstr(">best 3<"))));
  EXPECT_EQ(session::ReadSession(folder_ / "sessions/trial", context_).needle.size(),
            trial.needle.size());
  EXPECT_TRUE(std::filesystem::exists(folder_ / "sessions/best_2/needle.csv"));
}

TEST_F(WhatIfTest, ATrialWithoutInsertionIsRefused) {
  session::Session trial = Insertion();
  trial.needle.resize(200);
  const TrialScene scene = Loaded(trial);
  EXPECT_THAT([&] { LineOfTrial(scene, trial); },
              ThrowsMessage<InputError>(HasSubstr("has no insertion")));
}

TEST_F(WhatIfTest, SettingsThatExcludeEachOtherAreRefused) {
  const auto file = folder_ / "what_if.json";
  WriteTextFile(file, R"({"format": "acus-what-if/1",
                          "motion": {"slowest_mm_per_s": 50, "fastest_mm_per_s": 20}})");
  EXPECT_THAT([&] { ReadWhatIfSettings(file); },
              ThrowsMessage<InputError>(HasSubstr("/motion: slowest_mm_per_s 50 lies above")));
  WriteTextFile(file, R"({"format": "acus-what-if/1"})");
  const WhatIfSettings read = ReadWhatIfSettings(file);
  const WhatIfSettings code;
  EXPECT_EQ(read.count, code.count);
  EXPECT_EQ(read.tilt_deg, code.tilt_deg);
  EXPECT_EQ(read.slowest_mm_per_s, code.slowest_mm_per_s);
  EXPECT_EQ(read.rate_hz, code.rate_hz);
}

}  // namespace
}  // namespace acus::trials
