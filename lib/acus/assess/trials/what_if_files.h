// The output folder of a what-if: table, page, and sessions to replay.
#pragma once

#include <filesystem>

#include "acus/assess/trials/what_if.h"

namespace acus::trials {

/// Writes into an existing folder what_if.csv (a row per alternative), what_if.json (format
/// acus-what-if-result/1: settings, line, the trial, the best), map.svg, what_if.html,
/// sessions/{trial, trial_line, best_1, ...}, and provenance.json. No measured times: the same
/// input gives the same bytes.
void WriteWhatIf(const std::filesystem::path& folder, const TrialScene& scene,
                 const session::Session& trial, const WhatIf& what_if,
                 const WhatIfSettings& settings, const RunContext& context);

/// For the terminal: the trial, and a line for each of the best alternatives.
std::string WhatIfText(const TrialScene& scene, const WhatIf& what_if, int best);

}  // namespace acus::trials
