#include "acus/assess/trials/difficulty.h"

#include "acus/assess/trials/trainee_session.h"
#include "acus/base/core/error.h"
#include "acus/base/core/parallel.h"
#include "acus/base/math/statistics.h"
#include "acus/run/training/score.h"

namespace acus::trials {
namespace {

constexpr double kConfidence = 0.95;
constexpr int kBootstrapDraws = 2000;

/// 1 - score, mean over the trials of one person.
double MissedBy(int person, const TrialScene& scene, const PlannedPath& path,
                const DifficultyOptions& options, const RunContext& context) {
  double sum = 0.0;
  for (int trial = 1; trial <= options.trials; ++trial) {
    const SimulatedTrial made =
        SimulateTrial(scene, path, options.grade, Message("person_", person), trial, context.seed,
                      options.rate_hz);
    sum += 1.0 - training::ScoreOf(RunTrial(scene, made.session, context).assessment);
  }
  return sum / options.trials;
}

}  // namespace

Difficulty DifficultyOf(const TrialScene& scene, const PlannedPath& path,
                        const DifficultyOptions& options, const RunContext& context) {
  std::vector<double> missed(static_cast<std::size_t>(options.persons));
  ParallelFor(options.persons, context.num_threads, [&](int person) {
    missed[static_cast<std::size_t>(person)] = MissedBy(person + 1, scene, path, options, context);
  });
  return {math::Mean(missed),
          math::BootstrapIntervalOfMean(missed, kConfidence, kBootstrapDraws, context.seed,
                                        "difficulty of " + scene.exercise.name)};
}

}  // namespace acus::trials
