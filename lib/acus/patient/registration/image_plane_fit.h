// Least squares over the place, rotation and scales of an image in the frame of a probe's marker.
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <vector>

namespace acus::registration {

/// Where an image is: p = origin_mm + axes * (u * mm_per_px.x, v * mm_per_px.y, 0).
struct ImagePlane {
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();
  Eigen::Vector2d mm_per_px = Eigen::Vector2d::Ones();

  Eigen::Vector3d At(const Eigen::Vector2d& point_px) const;
};

/// Changes of an ImagePlane: origin (mm), rotation before its axes (rad), both scales (mm per px).
using PlaneVector = Eigen::Matrix<double, 8, 1>;
using PlaneMatrix = Eigen::Matrix<double, 8, 8>;

/// One measured point: a wire that the image's plane cuts (two residuals, pixels), or a place
/// (three, mm, in the probe's frame).
struct PlanePoint {
  std::size_t cluster = 0;  ///< Points of one cluster share errors.
  Eigen::Vector2d point_px = Eigen::Vector2d::Zero();
  bool is_wire = false;
  Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();    ///< On the wire, or the place.
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();  ///< Of the wire.
};

struct PlaneFit {
  ImagePlane plane;
  /// One per point, along columns, rows and out of the plane: pixels of wires (and 0), mm of
  /// places.
  std::vector<Eigen::Vector3d> residuals;
  std::vector<bool> used;
  std::size_t num_clusters = 0;                  ///< With a point that is used.
  PlaneMatrix normal = PlaneMatrix::Zero();      ///< J^T J over the points used.
  PlaneMatrix covariance = PlaneMatrix::Zero();  ///< Jackknife over the clusters.

  /// d(probe_mm)/d(PlaneVector) at a pixel.
  Eigen::Matrix<double, 3, 8> JacobianAt(const Eigen::Vector2d& point_px) const;
};

/// The affine image that leaves the least absolute distances to the places of the pixels, with its
/// axes made perpendicular. @pre the pixels do not lie on a line.
ImagePlane LinearPlane(const std::vector<Eigen::Vector2d>& points_px,
                       const std::vector<Eigen::Vector3d>& places_mm);

/// Least squares by Ceres on one thread, from `start`: first with a loss that outliers barely pull,
/// then over the points within five robust standard deviations along each axis until these stay the
/// same.
/// @pre the points are all wires or all places. @throws NoAnswerError if no solution is found.
PlaneFit FitPlane(const std::vector<PlanePoint>& points, const ImagePlane& start);

}  // namespace acus::registration
