// Rigid registration of markers whose localisation error differs between markers and directions.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "acus/patient/registration/rigid_registration.h"

namespace acus::registration {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// How badly one marker is localised in each space: covariances in the frame of that space, mm^2.
struct MarkerNoise {
  Eigen::Matrix3d reference_mm2 = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d ct_mm2 = Eigen::Matrix3d::Zero();
};

/// How badly a pose is known, to first order: x_ct errs by rotation x (x_ct - centre) +
/// translation.
struct PoseError {
  Eigen::Vector3d centre_ct_mm = Eigen::Vector3d::Zero();
  Matrix6 covariance = Matrix6::Zero();  ///< Of (rotation about CT axes in rad, translation in mm).

  /// The expected TRE at a target.
  TreEstimate At(const Eigen::Vector3d& target_ct_mm) const;
};

struct WeightedFit {
  MarkerFit fit;
  PoseError error;
  /// Sum of r^T S^-1 r; chi-square with 3 n - 6 degrees of freedom if the noise is as stated.
  double chi_square = 0.0;
};

/// The pose of greatest likelihood for normal errors: minimises the sum of r_i^T S_i^-1 r_i with
/// r_i = ct_i - T reference_i and S_i = R reference_mm2_i R^T + ct_mm2_i, by Gauss-Newton with R in
/// S_i from the step before (Ohta & Kanatani 1998; Balachandran & Fitzpatrick 2009,
/// doi:10.1117/12.813887). With equal isotropic noise it is FitMarkers().
///
/// @throws InputError as FitMarkers does, or if a marker has no error in some direction.
WeightedFit FitMarkersWeighted(const transforms::Markers& reference_mm,
                               const transforms::Markers& ct_mm,
                               const std::vector<MarkerNoise>& noise);

/// The error of the pose that plain least squares (FitMarkers) finds under such noise, to first
/// order: N^-1 (sum J^T S J) N^-1 with N = sum J^T J (Danilchenko & Fitzpatrick 2011,
/// doi:10.1109/TMI.2010.2091513). For equal isotropic noise At() is ExpectedTre().
PoseError ErrorOfUnweightedFit(const transforms::Markers& reference_mm,
                               const Eigen::Isometry3d& ct_from_reference,
                               const std::vector<MarkerNoise>& noise);

/// The same isotropic noise of all markers, as if all of it were in CT.
std::vector<MarkerNoise> IsotropicNoise(Eigen::Index num_markers, double fle_rms_mm);

}  // namespace acus::registration
