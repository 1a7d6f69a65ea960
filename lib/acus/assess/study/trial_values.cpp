#include "acus/assess/study/trial_values.h"

#include <vector>

#include "acus/base/math/statistics.h"

namespace acus::study {

ByCode ValuesOf(std::span<const TrialRecord> trials, const std::string& exercise,
                const MetricKey& metric) {
  ByCode values;
  for (const TrialRecord& trial : trials) {
    if (trial.exercise != exercise) continue;
    const auto found = trial.metrics.find(metric);
    if (found != trial.metrics.end()) values[trial.code][trial.trial] = found->second;
  }
  return values;
}

double MeanOf(const TrialValues& trials) {
  std::vector<double> values;
  for (const auto& [trial, value] : trials) values.push_back(value);
  return math::Mean(values);
}

}  // namespace acus::study
