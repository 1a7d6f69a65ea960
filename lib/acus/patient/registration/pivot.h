// Pivot calibration: where the tip of a tracked pointer is, from poses while it turns about its
// tip.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <span>
#include <vector>

namespace acus::registration {

struct PivotCalibration {
  Eigen::Vector3d tip_mm;                   ///< In the tool's frame.
  Eigen::Vector3d pivot_mm;                 ///< In the reference frame.
  double residual_coordinate_rms_mm = 0.0;  ///< RMS over all coordinates of all poses used.
  double residual_rms_mm = 0.0;             ///< RMS length over the poses used: sqrt(3) times that.
  Eigen::Vector3d tip_sd_mm;  ///< Standard error along the principal directions, largest last.
  double tilt_deg = 0.0;      ///< RMS turn that the weakest direction of the tip has seen.
  std::vector<double> residual_mm;  ///< Length, one per pose given (also those omitted).
  std::vector<bool> used;           ///< One per pose given.
};

/// Least squares over all poses: R_i tip + t_i = pivot.
///
/// Yaniv 2015 (doi:10.1117/12.2081348), "algebraic one-step".
/// @param reference_from_tool  At least 3 poses.
/// @throws InputError if there are fewer than 3 poses.
/// @throws NoAnswerError if they turn too little (tilt_deg below 3) to determine the tip.
PivotCalibration CalibratePivot(std::span<const Eigen::Isometry3d> reference_from_tool);

/// The same with poses omitted that do not fit: a first fit of least absolute residuals, then
/// repeated least squares over the poses within 4 standard deviations (from the median residual).
/// Stands up to about a third of wrong poses.
PivotCalibration CalibratePivotRobustly(std::span<const Eigen::Isometry3d> reference_from_tool);

/// Refuses a tip that is in another unit than mm.
/// @throws InputError that names the likely unit.
void RequireTipInMillimetres(const PivotCalibration& calibration,
                             std::span<const Eigen::Isometry3d> poses);

/// Refuses a calibration that cannot be that of a pivoted pointer.
/// @param limit_mm  Largest RMS length of the residuals.
/// @throws NoAnswerError if the residuals are larger or fewer than 60 % of the poses were used. The
///     message says what probably happened: outliers, a pointer that was not pivoted, or a tip that
///     slid.
void RequirePivoted(const PivotCalibration& calibration,
                    std::span<const Eigen::Isometry3d> reference_from_tool, double limit_mm);

/// Poses reference_from_tool of one file or folder: a folder of text files with 4 x 4 matrices (in
/// order of name), one such file, or a CSV stream of a session (x_mm, y_mm, z_mm, qw, qx, qy, qz;
/// rows whose status is not OK are omitted).
/// @throws InputError with file and place.
std::vector<Eigen::Isometry3d> ReadPoses(const std::filesystem::path& path);

}  // namespace acus::registration
