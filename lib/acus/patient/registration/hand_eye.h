// Calibrations between two trackers of one moving body: a haptic device's handle that bears a
// marker.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

namespace acus::registration {

/// The two unknown transforms of A_i X = Z B_i.
struct HandEye {
  Eigen::Isometry3d handle_from_marker = Eigen::Isometry3d::Identity();   ///< X.
  Eigen::Isometry3d device_from_tracker = Eigen::Isometry3d::Identity();  ///< Z.
  double rms_mm = 0.0;   ///< Length of the translation that A_i X and Z B_i differ by.
  double rms_deg = 0.0;  ///< The same of the angle.
  /// How far the body turned about the weakest direction, RMS, degrees.
  double turn_deg = 0.0;
  Eigen::Vector3d
      handle_sd_mm;  ///< Standard error of X's translation along its principal directions.
  Eigen::Vector3d device_sd_mm;     ///< The same of Z.
  std::vector<double> residual_mm;  ///< One per pair given.
  std::vector<bool> used;           ///< One per pair given.
};

/// Finds both transforms from poses of the same body at the same moments.
///
/// Rotations in closed form (Shah 2013, doi:10.1115/1.4024473: the singular vectors of
/// sum B_i (x) A_i), translations by least squares, then Gauss-Newton over all twelve parameters,
/// in which 1 mm and 1 mm at `arm_mm` from the handle count alike. Pairs that do not fit are left
/// out with reweighting, up to about a third.
///
/// @param device_from_handle   A_i, from the haptic device.
/// @param tracker_from_marker  B_i, from the tracker.
/// @throws InputError if there are fewer than 4 pairs, or the counts differ.
/// @throws NoAnswerError if the body turned about one axis only, or by less than 5 degrees: then X
///     and Z slide along that axis.
HandEye CalibrateHandEye(std::span<const Eigen::Isometry3d> device_from_handle,
                         std::span<const Eigen::Isometry3d> tracker_from_marker,
                         double arm_mm = 100.0);

/// Refuses pairs of poses that are not of one body.
/// @param limit_mm  Largest RMS of the residuals' lengths.
/// @throws NoAnswerError if the residuals are larger or fewer than 60 % of the pairs were used; the
///     message says what probably happened: clocks that differ, or a marker that moved on the body.
void RequireOneBody(const HandEye& result, double limit_mm);

/// X of A X = X B for pairs of *motions*: A takes the handle at one moment to another (in the
/// handle's frame), B the marker. For devices whose base is not fixed to the tracker for long.
/// Rotation by Park & Martin 1994 (doi:10.1109/70.326576), translation by least squares.
/// @throws as CalibrateHandEye, at least 2 motions.
Eigen::Isometry3d SolveAxXb(std::span<const Eigen::Isometry3d> handle_motion,
                            std::span<const Eigen::Isometry3d> marker_motion);

}  // namespace acus::registration
