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
  /// Turns directions at rest to where the tissue has turned them.
  Eigen::Quaterniond world_from_rest = Eigen::Quaterniond::Identity();
  double residual_mm = 0.0;  ///< Of the inverse: 0 where nothing moves.

  /// d rest / d world, inverse(F) of eq. 3, at the tool's origin: velocities of a tool in held
  /// breath. The identity where the field folds; never larger than kMostPerWorld (Frobenius norm).
  Eigen::Matrix3d rest_per_world = Eigen::Matrix3d::Identity();
  Eigen::Vector3d axis_at_rest = Eigen::Vector3d::UnitZ();   ///< Unit length.
  Eigen::Vector3d axis_in_world = Eigen::Vector3d::UnitZ();  ///< The same as the hand holds it.
  double axis_per_world = 1.0;  ///< Length at rest of the unit axis in the world.

  /// Tissue that is compressed to less than a fifth in all directions is beyond any breath.
  static constexpr double kMostPerWorld = 8.66;
};

/// The tissue at the tool's origin, and how it is turned there. The tool's `axis` (unit, in its own
/// frame) becomes the direction at rest that the motion has turned to it, eq. 3. For forces see
/// CarryToWorld.
///
/// One iteration a step in normal breathing; up to four where that leaves more than 2 um, as
/// after a jump. Bounded and finite for any pose that is finite; a pose that is not comes back as
/// it is. Allocates nothing.
/// @param adds_motion  Line 7 of algorithm 1 as printed: X = x + u(X) with the X of the step
/// before,
///     which doubles the motion; the residual says by how much the tool is off.
ToolAtRest AtRest(const MotionMap& map, const Eigen::Isometry3d& ct_from_tool,
                  const Eigen::Vector3d& axis, ToolTrack& track, bool adds_motion = false) noexcept;

/// From what acts on the tool at rest to what the hand feels: the force and torque that do the same
/// work. With v the velocity of the tool's origin and w its angular velocity, in held breath, the
/// tool at rest moves with V = inverse(F) v and turns with its axis, which follows the tissue:
///     force . v + torque . w = rest_force . V + rest_torque . W        for all v and w,
/// so the force is transposed(inverse(F)) rest_force, less what a torque does when the axis turns
/// from place to place. Not a rotation: that would give energy to a hand that goes in where tissue
/// is compressed and out where it is stretched.
/// @param force, torque  in CT axes, N and N mm, about the tool's origin; both in place. Finite if
///     they are. Costs 12 evaluations of the field if there is a torque, else none.
void CarryToWorld(const MotionMap& map, const ToolAtRest& tool, Eigen::Vector3d& force,
                  Eigen::Vector3d& torque) noexcept;

}  // namespace acus::breathing
