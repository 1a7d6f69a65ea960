// A registration with its errors and warnings, as a table and as JSON.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/registration/landmark_registration.h"
#include "acus/patient/registration/pivot.h"

namespace acus::registration {

/// Per point: the length of its residual, and its distance from where the others put it.
std::vector<double> ResidualsMm(const RegistrationReport& report);
std::vector<std::optional<double>> ErrorsByOthersMm(const RegistrationReport& report);

/// For the terminal: points, totals, targets, outliers.
std::string TableText(const RegistrationReport& report);
std::string TableText(const PivotCalibration& calibration);

/// JSON of format acus-registration/1 and acus-pivot/1, without provenance.
nlohmann::json ToJson(const RegistrationReport& report);
nlohmann::json ToJson(const PivotCalibration& calibration);

/// Writes `registration.json` and `provenance.json` into an existing folder; for landmarks also
/// `ct_from_reference.tfm`.
void WriteResult(const std::filesystem::path& folder, const RegistrationReport& report,
                 const RunContext& context);
void WriteResult(const std::filesystem::path& folder, const PivotCalibration& calibration,
                 const RunContext& context);

}  // namespace acus::registration
