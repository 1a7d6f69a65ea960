// A replay's time against what acus-tradeoff predicted when it chose the scenario's values.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "acus/scene/scenario/evidence.h"

namespace acus::replay {

/// What reading the thread's clock twice costs at least, s: it is in each time taken with it.
double CpuClockCostSeconds();

/// Medians and percentiles. @param step_cpu_s  Of each step, s. @param image_cpu_s  Of each image.
scenario::Cost CostOf(std::span<const double> step_cpu_s, std::span<const double> image_cpu_s);

struct CostCheck {
  scenario::Evidence evidence;
  scenario::Cost measured;  ///< By this replay.
  std::string machine;      ///< It ran on.

  bool OnSameMachine() const { return machine == evidence.machine; }
};

/// One line for each number that both have: predicted, measured, how much more or less; first what
/// the values were chosen for, and whether this is another machine. Empty if nothing is common.
std::string TextOf(const CostCheck& check);

/// The same as names and values.
std::vector<std::pair<std::string, std::string>> FactsOf(const CostCheck& check);

/// {"asked", "machine", "predicted_on", "same_machine", "predicted": {...}, "measured": {...},
/// "measured_over_predicted": {...}}, keys of times as in the scenario's evidence.
nlohmann::json ToJson(const CostCheck& check);

}  // namespace acus::replay
