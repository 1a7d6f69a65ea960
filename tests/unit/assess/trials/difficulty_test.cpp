#include "acus/assess/trials/difficulty.h"

#include <gmock/gmock.h>

#include "support/trial_folder.h"

namespace acus::trials {
namespace {

class DifficultyTest : public testing_support::TrialFolder {
 protected:
  Difficulty Of(const std::string& grade, int num_threads = 1) {
    const TrialScene scene = Loaded(Insertion());
    context_.num_threads = num_threads;
    DifficultyOptions options;
    options.grade = ReadTraineeSkill(std::filesystem::path(ACUS_SOURCE_DIR) / "configs/trainees" /
                                     (grade + ".json"));
    options.rate_hz = 200.0;
    return DifficultyOf(scene, PlannedPathOf(scene), options, context_);
  }
};

TEST_F(DifficultyTest, FallsWithTheSkillOfTheTrainees) {
  const Difficulty novices = Of("novice");
  const Difficulty experts = Of("expert");
  EXPECT_GT(novices.interval.low, experts.interval.high);
  for (const Difficulty& one : {novices, experts}) {
    EXPECT_GE(one.interval.low, 0.0);
    EXPECT_LE(one.interval.low, one.value);
    EXPECT_GE(one.interval.high, one.value);
    EXPECT_LE(one.interval.high, 1.0);
  }
}

TEST_F(DifficultyTest, HasTheSameBitsWithAnyNumberOfThreads) {
  const Difficulty one = Of("novice", 1);
  const Difficulty four = Of("novice", 4);
  EXPECT_EQ(one.value, four.value);
  EXPECT_EQ(one.interval.low, four.interval.low);
  EXPECT_EQ(one.interval.high, four.interval.high);
}

}  // namespace
}  // namespace acus::trials
