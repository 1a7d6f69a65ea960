// Landmarks in two spaces to a transform, with its errors and warnings.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acus/patient/registration/weighted_registration.h"

namespace acus::registration {

struct RegistrationSettings {
  std::optional<double> fle_rms_mm =
      {};                           ///< Localisation error, if known; else from the residuals.
  bool leave_out_outliers = false;  ///< Wrong points are omitted, not only named.
  bool find_order = false;          ///< A better order of the points is taken, not only named.
  double confidence = 0.95;         ///< Of TargetError::bound_mm.
};

struct TargetError {
  std::string name;
  Eigen::Vector3d ct_mm;
  TreEstimate tre;
  double bound_mm = 0.0;  ///< The error is below it with RegistrationSettings::confidence.
};

struct RegistrationReport {
  transforms::MarkerPairs pairs;  ///< Those that were used.
  MarkerFit fit;
  PoseError pose_error;
  Eigen::Vector3d spread_mm;  ///< Of the CT markers, see SpreadMm().
  double fle_rms_mm = 0.0;
  bool fle_is_given = false;          ///< Otherwise it is estimated from FRE.
  bool is_weighted = false;           ///< The files gave a localisation error for each point.
  double confidence = 0.95;           ///< Of the targets' bounds.
  std::optional<double> fre_p_value;  ///< Chance of such an FRE or a larger one, if FLE is given.
  std::vector<std::optional<LeaveOneOut>> leave_one_out;  ///< Per marker; empty with 3 markers.
  std::vector<Outlier> outliers;  ///< Among the points given; `marker` counts those.
  std::vector<std::string> outlier_names;
  std::vector<std::string> left_out;  ///< Names of those outliers, if they were omitted.
  std::vector<TargetError> targets;
  std::vector<std::string> notes;  ///< Worth knowing, but no reason to worry.
  std::vector<std::string> warnings;
};

/// Registers the pairs, estimates the errors at the targets (points in CT), looks for outliers and
/// for the usual mistakes. With localisation errors in the pairs the fit is weighted by them.
/// @throws InputError as FitMarkers does, if fle_rms_mm is not positive, or if it is given beside
///     localisation errors of the points.
/// @throws NoAnswerError if outliers are to be omitted, but the points cannot decide which are
/// wrong.
RegistrationReport Register(const transforms::MarkerPairs& pairs,
                            const std::optional<transforms::Landmarks>& targets_ct,
                            const RegistrationSettings& settings = {});

}  // namespace acus::registration
