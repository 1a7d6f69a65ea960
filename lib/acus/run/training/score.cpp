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
  double weights = 0.0;
  double of_musts = 1.0;
  for (const GoalResult& result : assessment.goals) {
    const double score = ScoreOfGoal(result);
    sum += result.goal.weight * score;
    weights += result.goal.weight;
    if (result.goal.must) of_musts *= score;
  }
  return of_musts * sum / weights;
}

}  // namespace acus::training
