// Comparison of two sets of metrics (metrics.json).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acus/assess/regression/comparison/check.h"
#include "acus/assess/regression/comparison/tolerances.h"

namespace acus::comparison {

/// Compares values by name: |a - b| <= absolute + relative * max(|a|, |b|). A metric that only one
/// has, or with another unit, is a failed check. `label_a`, `label_b` name the files in messages.
/// @throws InputError if a document is not {"metrics": [{"name", "unit", "value"}]}.
std::vector<Check> CompareMetrics(const nlohmann::json& a, const std::string& label_a,
                                  const nlohmann::json& b, const std::string& label_b,
                                  const MetricTolerances& tolerances);

}  // namespace acus::comparison
