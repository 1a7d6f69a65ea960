#include "acus/assess/trials/what_if.h"

#include <algorithm>
#include <numeric>

#include "acus/base/core/cpu_time.h"
#include "acus/base/core/parallel.h"
#include "acus/run/training/score.h"

namespace acus::trials {
namespace {

std::vector<std::size_t> RankingOf(const std::vector<Outcome>& outcomes) {
  std::vector<std::size_t> ranking(outcomes.size());
  std::iota(ranking.begin(), ranking.end(), std::size_t{0});
  const auto distance_mm = [&](std::size_t i) {
    return ValueOf(outcomes[i].result.assessment, "tip to target at the end").value_or(0.0);
  };
  std::ranges::stable_sort(ranking, [&](std::size_t a, std::size_t b) {
    if (outcomes[a].score != outcomes[b].score) return outcomes[a].score > outcomes[b].score;
    return distance_mm(a) < distance_mm(b);
  });
  return ranking;
}

}  // namespace

std::optional<double> ValueOf(const training::Assessment& assessment, const std::string& metric) {
  const auto found = std::ranges::find(assessment.metrics, metric, &training::Metric::name);
  if (found == assessment.metrics.end()) return std::nullopt;
  return found->value;
}

bool IsSingle(const InsertionChange& change) {
  const int changed = (change.along_mm != 0.0) + (change.across_mm != 0.0) +
                      (change.steeper_rad != 0.0) + (change.sideways_rad != 0.0) +
                      (change.depth_mm != 0.0) + (change.speed_factor != 1.0) +
                      (change.breath_cycles != 0.0);
  return changed <= 1;
}

WhatIf RunWhatIf(const TrialScene& scene, const session::Session& trial,
                 const WhatIfSettings& settings, const RunContext& context) {
  WhatIf what_if;
  what_if.line = LineOfTrial(scene, trial);
  what_if.trial = RunTrial(scene, trial, context).assessment;
  what_if.trial_score = training::ScoreOf(what_if.trial);
  const auto alternatives = MakeAlternatives(scene, what_if.line, settings,
                                             scene.scene.breathing.has_value(), context.seed);
  what_if.outcomes.resize(alternatives.size());
  const double cpu_begin_s = ProcessCpuSeconds();
  const std::size_t piece = std::max<std::size_t>(1, alternatives.size() / 50);
  for (std::size_t from = 0; from < alternatives.size(); from += piece) {
    context.Checkpoint("alternatives",
                       static_cast<double>(from) / static_cast<double>(alternatives.size()));
    const std::size_t count = std::min(piece, alternatives.size() - from);
    ParallelFor(static_cast<int>(count), context.num_threads, [&](int i) {
      const std::size_t n = from + static_cast<std::size_t>(i);
      Outcome& outcome = what_if.outcomes[n];
      outcome.alternative = alternatives[n];
      outcome.result = RunTrial(
          scene, SessionOf(scene, trial, what_if.line, alternatives[n], settings), context);
      outcome.score = training::ScoreOf(outcome.result.assessment);
    });
  }
  what_if.cpu_s = ProcessCpuSeconds() - cpu_begin_s;
  for (const Outcome& outcome : what_if.outcomes) what_if.step_cpu_s += outcome.result.step_cpu_s;
  what_if.ranking = RankingOf(what_if.outcomes);
  return what_if;
}

}  // namespace acus::trials
