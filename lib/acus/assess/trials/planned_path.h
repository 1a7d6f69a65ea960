// The path that an exercise plans, and the pose of a probe that shows it.
#pragma once

#include <Eigen/Geometry>

#include "acus/assess/trials/trial_line.h"

namespace acus::trials {

/// In CT space.
struct PlannedPath {
  Eigen::Vector3d entry_ct_mm;
  Eigen::Vector3d target_ct_mm;
  Eigen::Vector3d axis_in_ct;    ///< Unit, from the entry to the target.
  Eigen::Vector3d inward_in_ct;  ///< Normal of the skin at the entry.
  Eigen::Vector3d face_ct_mm;    ///< Centre of the probe's face, on the skin beyond the entry.
};

/// From the points `entry` and `target` of the scenario's corridor.
/// @throws InputError if there is no corridor or a point is missing, or they coincide.
PlannedPath PlannedPathOf(const TrialScene& scene);

/// The probe's pose whose image plane contains a needle's line and the direction from the face to
/// the target: +x away from the entry, +y into the body.
/// @param offset_mm  Offset of the plane along its normal. @param turn_rad  Rotation about the
///     beam.
Eigen::Isometry3d ProbeAlongNeedle(const PlannedPath& path, const Eigen::Vector3d& axis_in_ct,
                                   double offset_mm, double turn_rad);

}  // namespace acus::trials
