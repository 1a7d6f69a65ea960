// A tool in a patient who breathes, as it would lie in the reference image: there all models of
// forces and tissue work (Fortmeier-2016, section 2.2 and algorithm 1).
#pragma once

#include <Eigen/Geometry>

#include "acus/physics/breathing/motion_map.h"

namespace acus::breathing {

/// What is kept of a tool from step to step. A plain value.
struct ToolTrack {
  bool started = false;
  Eigen::Vector3d world_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d rest_mm = Eigen::Vector3d::Zero();
  Eigen::Quaterniond world_from_rest = Eigen::Quaterniond::Identity();
};

struct ToolAtRest {
  Eigen::Isometry3d ct_from_tool = Eigen::Isometry3d::Identity();
  /// Turns forces and directions at rest to where the tissue has turned them.
  Eigen::Quaterniond world_from_rest = Eigen::Quaterniond::Identity();
  double residual_mm = 0.0;  ///< Of the inverse: 0 where nothing moves.
};

/// The tissue at the tool's origin, and how it is turned there. The tool's `axis` (unit, in its own
/// frame) becomes the direction at rest that the motion has turned to it, eq. 3, and a force along
/// one becomes a force along the other.
///
/// One iteration a step in normal breathing; up to four where that leaves more than 2 um, as
/// after a jump. Bounded and finite for any pose that is finite; a pose that is not comes back as
/// it is. Allocates nothing.
ToolAtRest AtRest(const MotionMap& map, const Eigen::Isometry3d& ct_from_tool,
                  const Eigen::Vector3d& axis, ToolTrack& track) noexcept;

}  // namespace acus::breathing
