#include "acus/run/training/score.h"

#include <cmath>

namespace acus::training {
namespace {

double ScoreOfGoal(const GoalResult& result) {
  if (result.met) return 1.0;
  if (!result.value) return 0.0;
  const double value = *result.value;
  const bool above = result.goal.at_most && value > *result.goal.at_most;
  const double limit = above ? *result.goal.at_most : result.goal.at_least.value_or(0.0);
  const double scale = limit == 0.0 ? 1.0 : std::abs(limit);
  return scale / (scale + std::abs(value - limit));
}

}  // namespace

double ScoreOf(const Assessment& assessment) {
  if (assessment.goals.empty()) return 1.0;
  double sum = 0.0;
  for (const GoalResult& goal : assessment.goals) sum += ScoreOfGoal(goal);
  return sum / static_cast<double>(assessment.goals.size());
}

}  // namespace acus::training
