// The chosen setting as a scenario, with the evidence.
#pragma once

#include <filesystem>

#include "acus/assess/tuning/budget.h"
#include "acus/scene/scenario/evidence.h"

namespace acus::tuning {

/// The evidence for the answer, for the scenario.
scenario::Evidence EvidenceOf(const BudgetAnswer& answer);

/// The given scenario with its changes, the chosen values and the evidence. Its paths are absolute:
/// it may be moved. @pre answer.Found().
nlohmann::json ChosenScenario(const BudgetAnswer& answer);

/// Writes it, whole or not at all, and reads it again as a check.
/// @throws InputError if it cannot be written.
void WriteChosenScenario(const std::filesystem::path& path, const BudgetAnswer& answer);

}  // namespace acus::tuning
