// What would have happened: alternatives to a trial's insertion, judged by its exercise and ranked.
#pragma once

#include <string>
#include <vector>

#include "acus/assess/trials/alternative.h"

namespace acus::trials {

/// An alternative and what came of it.
struct Outcome {
  Alternative alternative;
  TrialResult result;
  double score = 0.0;  ///< training::ScoreOf the assessment.
};

struct WhatIf {
  training::Assessment trial;  ///< Of the trial as it was recorded.
  double trial_score = 0.0;
  TrialLine line;
  std::vector<Outcome> outcomes;  ///< As MakeAlternatives made them; the first is the trial's line.
  std::vector<std::size_t> ranking;  ///< Places in `outcomes`, the best first.
  double step_cpu_s = 0.0;           ///< Thread CPU time of all steps.
  double cpu_s = 0.0;                ///< CPU time of steps and metrics, all threads.
};

/// Steps and judges all alternatives on context.num_threads threads. The results are those of full
/// replays of the same sessions, bit for bit, with any number of threads.
/// Ranked by score, then by the tip's distance to the target at the end, then by their number.
/// @throws InputError as LineOfTrial, or if a goal's metric is not there.
WhatIf RunWhatIf(const TrialScene& scene, const session::Session& trial,
                 const WhatIfSettings& settings, const RunContext& context);

/// Whether it differs from the trial's line in at most one value.
bool IsSingle(const InsertionChange& change);

/// The value of a metric; nothing if the assessment lacks it.
std::optional<double> ValueOf(const training::Assessment& assessment, const std::string& metric);

/// "5 degrees steeper, entry 6 mm towards the head"; "as in the trial" without a change.
std::string ChangeText(const TrialLine& line, const InsertionChange& change);

/// What came of it beside the trial's line: "misses bone and ends 2 mm from the target (8.4 mm)".
std::string OutcomeText(const WhatIf& what_if, const Outcome& outcome,
                        const std::vector<std::string>& avoid);

}  // namespace acus::trials
