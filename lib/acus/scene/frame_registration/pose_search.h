// The pose of the probe whose simulated image fits a recorded frame best, with its uncertainty.
// Equations and measurements: docs/models/frame_registration.md.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string_view>

#include "acus/base/core/run_context.h"
#include "acus/scene/frame_registration/frame_similarity.h"

namespace acus::frame_registration {

/// Shifts (mm) along the axes of the start's probe frame, lateral, axial and elevational; then
/// rotations (deg) about these axes through a point at half the depth.
using PoseChange = Eigen::Matrix<double, 6, 1>;
inline constexpr std::array<std::string_view, 6> kChangeNames = {
    "lateral_mm",        "axial_mm",        "elevational_mm",
    "about_lateral_deg", "about_axial_deg", "about_elevational_deg"};

/// @param pivot_mm  Depth of the centre of rotation.
Eigen::Isometry3d Changed(const Eigen::Isometry3d& start, const PoseChange& change,
                          double pivot_mm);

struct SearchSettings {
  double start_mm = 3.0;   ///< Standard deviation of the start's place along each axis.
  double start_deg = 3.0;  ///< ... of its rotation about each axis.
  int samples = 1600;      ///< Poses around the start that are tried first.
};

struct FramePose {
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
  PoseChange change = PoseChange::Zero();    ///< From the start.
  PoseChange sd = PoseChange::Zero();        ///< Standard deviations of the change.
  Eigen::Matrix<double, 6, 6> covariance{};  ///< Covariance of the change, in mm and deg.
  double similarity = 0.0;                   ///< FrameSimilarity::At(), fine resolution.
  double start_similarity = 0.0;
  /// Lateral and axial distance of another pose that fits about as well, if there is one.
  std::optional<double> rival_mm{};

  /// True where the frame determines the pose: less than half the start's standard deviation.
  std::array<bool, 6> determined(const SearchSettings& settings) const;
};

/// Random poses around the start, the best of them refined by the simplex method in two
/// resolutions. The same result with any number of threads.
/// @throws InputError as FrameSimilarity, or if a setting is not positive; NoAnswerError if no pose
///     explains more than a few hundredths of the frame's variance.
FramePose FindFramePose(const image::GrayImage& recorded, const acoustics::Probe& probe,
                        const SimulatedTissue& simulated, const Eigen::Isometry3d& start,
                        const SearchSettings& settings, const RunContext& context);

}  // namespace acus::frame_registration
