// A registration with everything that a user should know of it, as a table and as JSON.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/run_context.h"
#include "registration/pivot.h"
#include "registration/rigid_registration.h"

namespace acus::registration {

struct TargetError {
  std::string name;
  Eigen::Vector3d ct_mm;
  TreEstimate tre;
};

struct RegistrationReport {
  MarkerPairs pairs;
  MarkerFit fit;
  Eigen::Vector3d spread_mm;  ///< Of the CT markers, see SpreadMm().
  double fle_rms_mm = 0.0;
  bool fle_is_given = false;          ///< Otherwise it is estimated from FRE.
  std::optional<double> fre_p_value;  ///< Chance of such an FRE or a larger one, if FLE is given.
  std::vector<std::optional<LeaveOneOut>> leave_one_out;  ///< Per marker; empty with 3 markers.
  std::vector<Outlier> outliers;
  std::vector<TargetError> targets;
  std::vector<std::string> warnings;
};

/// Registers the pairs, estimates the errors at the targets (points in CT), looks for outliers and
/// for the usual mistakes. `fle_rms_mm` is the localisation error if it is known from elsewhere.
/// @throws InputError as FitMarkers does, or if fle_rms_mm is not positive.
RegistrationReport Register(const MarkerPairs& pairs, const std::optional<Landmarks>& targets_ct,
                            std::optional<double> fle_rms_mm);

/// Per point: the length of its residual, and its distance from where the others put it.
std::vector<double> ResidualsMm(const RegistrationReport& report);
std::vector<std::optional<double>> ErrorsByOthersMm(const RegistrationReport& report);

/// For the terminal: points, totals, targets, outliers.
std::string TableText(const RegistrationReport& report);
std::string TableText(const PivotCalibration& calibration);

/// Of format acus-registration/1 and acus-pivot/1, without provenance.
nlohmann::json ToJson(const RegistrationReport& report);
nlohmann::json ToJson(const PivotCalibration& calibration);

/// Writes `registration.json` and `provenance.json` into an existing folder; for landmarks also
/// `ct_from_reference.tfm`.
void WriteResult(const std::filesystem::path& folder, const RegistrationReport& report,
                 const RunContext& context);
void WriteResult(const std::filesystem::path& folder, const PivotCalibration& calibration,
                 const RunContext& context);

}  // namespace acus::registration
