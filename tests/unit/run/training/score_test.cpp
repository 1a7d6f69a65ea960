#include "acus/run/training/score.h"

#include <gtest/gtest.h>

namespace acus::training {
namespace {

TEST(ScoreOf, IsContinuousAtTheLimitAndFallsBeyond) {
  const auto score = [](double value, double at_most, bool met) {
    Assessment a;
    a.goals.push_back({{"m", at_most, std::nullopt, ""}, "", value, met});
    return ScoreOf(a);
  };
  EXPECT_EQ(score(3.0, 3.0, true), 1.0);
  EXPECT_NEAR(score(3.0 + 1e-9, 3.0, false), 1.0, 1e-9);
  EXPECT_NEAR(score(6.0, 3.0, false), 0.5, 1e-15);
  EXPECT_NEAR(score(1.0, 0.0, false), 0.5, 1e-15);
  Assessment missing;
  missing.goals.push_back({{"m", 3.0, std::nullopt, ""}, "", std::nullopt, false});
  EXPECT_EQ(ScoreOf(missing), 0.0);
  EXPECT_EQ(ScoreOf({}), 1.0);
}

TEST(ScoreOf, WeighsGoalsAndFailsWithAMust) {
  Assessment a;
  a.goals = {{{"attempts", 1.0, {}, "", 3.0}, "", 1.0, true},
             {{"tip to target at the end", 3.0, {}, "", 1.0}, "mm", 9.0, false}};
  EXPECT_NEAR(ScoreOf(a), (3.0 + 1.0 / 3.0) / 4.0, 1e-15);
  EXPECT_TRUE(a.Passed());
  a.goals[1].goal.must = true;
  EXPECT_NEAR(ScoreOf(a), (3.0 + 1.0 / 3.0) / 4.0 / 3.0, 1e-15);
  EXPECT_FALSE(a.Passed());
  a.goals[1].value = 3.0 + 1e-9;  // Continuous at the limit.
  EXPECT_NEAR(ScoreOf(a), 1.0, 1e-9);
}

}  // namespace
}  // namespace acus::training
