// The values of one metric, by participant and trial.
#pragma once

#include <map>
#include <span>
#include <string>

#include "acus/assess/study/study_data.h"

namespace acus::study {

/// trial -> value, for one participant.
using TrialValues = std::map<int, double>;
using ByCode = std::map<std::string, TrialValues>;

/// Values by participant, from the trials of an exercise that have the metric.
ByCode ValuesOf(std::span<const TrialRecord> trials, const std::string& exercise,
                const MetricKey& metric);

/// @pre not empty.
double MeanOf(const TrialValues& trials);

}  // namespace acus::study
