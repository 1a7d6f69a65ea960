// Spatial calibration of an ultrasound probe: where the pixels of its images are in the frame of
// the marker on it.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "acus/patient/registration/wire_phantom.h"

namespace acus::registration {

/// An image of the wires: the pose of its plane's marker, and where each wire is seen.
struct WireImage {
  Eigen::Isometry3d probe_from_phantom = Eigen::Isometry3d::Identity();
  /// (column, row) of each wire of the phantom, in its order; nothing where it is not seen.
  std::vector<std::optional<Eigen::Vector2d>> points_px = {};
};

/// A point whose place in the frame of the probe's marker is measured, such as the tip of a stylus.
struct SeenPoint {
  Eigen::Vector2d point_px = Eigen::Vector2d::Zero();  ///< (column, row).
  Eigen::Vector3d probe_mm = Eigen::Vector3d::Zero();
};

struct ProbeCalibrationSettings {
  /// Columns and rows of the images, whose corners are reported; 0: those of the points.
  Eigen::Vector2d image_px = Eigen::Vector2d::Zero();
  double limit_mm = 5.0;     ///< Largest RMS of the residuals that is accepted.
  double confidence = 0.95;  ///< Of the bounds and intervals.
};

/// The remaining error of one measured point.
struct PointResidual {
  std::size_t image = 0;  ///< Index of the image, or of the point.
  std::size_t wire = 0;   ///< Index of the wire; 0 for points of a stylus.
  /// Along the columns and rows, and out of the image's plane: place by the calibration minus place
  /// measured. Wires have no part out of the plane.
  Eigen::Vector3d residual_mm = Eigen::Vector3d::Zero();
  bool used = true;  ///< False: an outlier, excluded.
};

/// The place of a middle wire by its image minus that by similar triangles, in the image's axes.
struct MiddleWireError {
  std::size_t image = 0;
  std::size_t pattern = 0;
  Eigen::Vector3d error_mm = Eigen::Vector3d::Zero();
};

/// How far the calibration may be wrong at a pixel.
struct PixelError {
  Eigen::Vector2d point_px = Eigen::Vector2d::Zero();
  Eigen::Vector3d sd_mm = Eigen::Vector3d::Zero();  ///< Along columns and rows, out of the plane.
  double bound_mm = 0.0;  ///< The error is below it with the settings' confidence.
};

struct ProbeCalibration {
  /// Axes of the image in mm: x along the columns (to higher column numbers), y along the rows, z
  /// out of the plane; origin at pixel (0, 0).
  Eigen::Isometry3d probe_from_image = Eigen::Isometry3d::Identity();
  Eigen::Vector2d mm_per_px = Eigen::Vector2d::Ones();
  Eigen::Vector2d mm_per_px_half_width = Eigen::Vector2d::Zero();  ///< Of its interval.
  std::vector<PointResidual> residuals = {};
  std::vector<MiddleWireError> middle_wires = {};  ///< Of complete N whose points are all used.
  std::vector<PixelError> corners = {};  ///< Upper left, upper right, lower left and right.
  std::size_t num_images = 0;            ///< With a point that is used.
  double in_plane_rms_mm = 0.0;          ///< Length in the image, of the points used.
  double out_of_plane_rms_mm = 0.0;      ///< Of the middle wires, or of a stylus's points.
  double constraint = 0.0;  ///< RMS by which the points move in the image, mm per mm at its
                            ///< corners, for the motion of the image that they determine least.

  /// ImageToProbe as PLUS has it: pixels to mm; its third axis is as long as the mean of the
  /// others.
  Eigen::Matrix4d ImageToProbe() const;
};

/// The calibration that minimises the squared distances in pixels between the wires' points and
/// where the image's plane cuts the wires, over position, rotation and both scales of the image.
///
/// Starts from the middle wires (MiddleWirePoint) by linear least absolute residuals; points beyond
/// five robust standard deviations are excluded (PointResidual::used). Covariance: jackknife over
/// the images (MacKinnon, Nielsen & Webb 2023), so that what the points of an image have in common,
/// such as the tracker's error, counts.
/// @throws NoAnswerError if fewer than 10 images show a complete N, the points lie on a line, they
/// do
///     not determine the calibration, the residuals are above the limit, or fewer than 60 % of the
///     points fit: the message says what to add.
/// @throws InputError if the scale is that of another unit.
ProbeCalibration CalibrateByWires(const WirePhantom& phantom, std::span<const WireImage> images,
                                  const ProbeCalibrationSettings& settings);

/// The same from points: minimises the squared distances in mm. @throws as above; at least 10
/// points.
ProbeCalibration CalibrateByPoints(std::span<const SeenPoint> points,
                                   const ProbeCalibrationSettings& settings);

}  // namespace acus::registration
