// Compares a replay's time with the prediction of acus-tradeoff for the scenario's values.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "acus/scene/scenario/evidence.h"

namespace acus::replay {

/// Smallest cost of reading the thread's clock twice, s: each time measured with it contains that.
double CpuClockCostSeconds();

/// Medians and percentiles. @param step_cpu_s  By step, s. @param image_cpu_s  By image, s.
scenario::Cost CostOf(std::span<const double> step_cpu_s, std::span<const double> image_cpu_s);

struct CostCheck {
  scenario::Evidence evidence;
  scenario::Cost measured;  ///< By this replay.
  std::string machine;      ///< The machine of the replay.

  bool OnSameMachine() const { return machine == evidence.machine; }
};

/// One line for each number that both have: predicted, measured, relative difference; first the
/// request for which the values were chosen, and whether this is another machine. Empty if there is
/// no common number.
std::string TextOf(const CostCheck& check);

/// The same as names and values.
std::vector<std::pair<std::string, std::string>> FactsOf(const CostCheck& check);

/// {"asked", "machine", "predicted_on", "same_machine", "predicted": {...}, "measured": {...},
/// "measured_over_predicted": {...}}, keys of times as in the scenario's evidence.
nlohmann::json ToJson(const CostCheck& check);

}  // namespace acus::replay
