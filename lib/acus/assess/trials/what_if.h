// Alternatives to a trial's insertion, assessed by its exercise and ranked.
#pragma once

#include <string>
#include <vector>

#include "acus/assess/trials/alternative.h"

namespace acus::trials {

/// An alternative and its results.
struct Outcome {
  Alternative alternative;
  TrialResult result;
  double score = 0.0;  ///< training::ScoreOf the assessment.
};

struct WhatIf {
  training::Assessment trial;  ///< Assessment of the recorded trial.
  double trial_score = 0.0;
  TrialLine line;
  std::vector<Outcome> outcomes;     ///< As from MakeAlternatives; the first is the trial's line.
  std::vector<std::size_t> ranking;  ///< Indices in `outcomes`, the best first.
  double step_cpu_s = 0.0;           ///< Thread CPU time of all steps.
  double cpu_s = 0.0;                ///< CPU time of steps and metrics, all threads.
};

/// Steps and assesses all alternatives on context.num_threads threads. The results have the bits of
/// full replays of the same sessions, with any number of threads. Ranked by score, then by the
/// tip's distance to the target at the end, then by their number.
/// @throws InputError as LineOfTrial, or if a goal's metric does not exist.
WhatIf RunWhatIf(const TrialScene& scene, const session::Session& trial,
                 const WhatIfSettings& settings, const RunContext& context);

/// True if it differs from the trial's line in at most one value.
bool IsSingle(const InsertionChange& change);

/// The value of a metric; nothing if the assessment lacks it.
std::optional<double> ValueOf(const training::Assessment& assessment, const std::string& metric);

/// "5 degrees steeper, entry 6 mm towards the head"; "as in the trial" without a change.
std::string ChangeText(const TrialLine& line, const InsertionChange& change);

/// The outcome relative to the trial's line: "misses bone and ends 2 mm from the target (8.4 mm)".
std::string OutcomeText(const WhatIf& what_if, const Outcome& outcome,
                        const std::vector<std::string>& avoid);

}  // namespace acus::trials
