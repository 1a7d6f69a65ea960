// A calibrated pair of cameras, and where a point is that both see.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "acus/rig/camera/camera_model.h"

namespace acus::camera {

/// Two cameras that stand fixed to each other. Poses are given in the left one's frame, mm.
struct StereoPair {
  CameraModel left, right;
  Eigen::Isometry3d right_from_left = Eigen::Isometry3d::Identity();  ///< mm.
  double reprojection_rms_px = 0.0;                                   ///< Of its calibration.

  double BaselineMm() const { return right_from_left.translation().norm(); }
};

/// A file of format acus-stereo/1, as acus-camera stereo writes it.
/// @throws InputError as ReadConfig and CameraModel do, for a matrix that is not rigid, or cameras
///     less than 1 mm apart.
StereoPair ReadStereo(const std::filesystem::path& path);
/// JSON of format acus-stereo/1, without the table of views.
nlohmann::json ToJson(const StereoPair& pair);

/// Throws unless a camera's own file and the pair's file speak of the same camera: width and
/// height equal, and every pixel of the corners and the middle of the image with its line of sight
/// to 1 px.
/// @param side  "left" or "right", for the message.
/// @throws InputError
void RequireSameCamera(const CameraModel& in_pair, const CameraModel& own, const char* side);

/// Where two lines of sight pass nearest to each other, in the left camera's frame, mm: the middle
/// of their common perpendicular (Hartley & Sturm 1997, "Triangulation"). Nothing if a pixel has
/// no line of sight, the lines are within 0.01 degrees of parallel, or the point is not before
/// both cameras.
std::optional<Eigen::Vector3d> Triangulate(const StereoPair& pair, const Eigen::Vector2d& left_px,
                                           const Eigen::Vector2d& right_px);

}  // namespace acus::camera
