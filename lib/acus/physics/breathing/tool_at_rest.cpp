#include "acus/physics/breathing/tool_at_rest.h"

#include <Eigen/LU>

namespace acus::breathing {
namespace {

constexpr int kMostIterations = 4;
constexpr int kFirstIterations = 30;
constexpr double kToleranceMm = 0.002;

/// Line 7 of algorithm 1 as printed.
math::InversePoint Added(const MotionMap& map, const Eigen::Vector3d& world_mm,
                         const Eigen::Vector3d& before_mm) noexcept {
  math::InversePoint point;
  point.rest_mm = world_mm + map.DisplacementMm(before_mm);
  point.residual_mm = (map.WorldMm(point.rest_mm) - world_mm).norm();
  return point;
}

}  // namespace

ToolAtRest AtRest(const MotionMap& map, const Eigen::Isometry3d& ct_from_tool,
                  const Eigen::Vector3d& axis, ToolTrack& track, bool adds_motion) noexcept {
  ToolAtRest out{.ct_from_tool = ct_from_tool};
  const Eigen::Vector3d world_mm = ct_from_tool.translation();
  if (!map.moves() || !ct_from_tool.matrix().allFinite()) {
    track.started = false;
    return out;
  }
  // Moved along with the tool since the step before.
  const Eigen::Vector3d start_mm =
      track.started ? Eigen::Vector3d(track.rest_mm + world_mm - track.world_mm) : world_mm;
  const math::InversePoint found =
      adds_motion
          ? Added(map, world_mm, track.started ? track.rest_mm : world_mm)
          : map.RestOf(world_mm, start_mm,
                       {.max_iterations = track.started ? kMostIterations : kFirstIterations,
                        .tolerance_mm = kToleranceMm});
  track = {true, world_mm, found.rest_mm, Eigen::Quaterniond::Identity()};
  out.residual_mm = found.residual_mm;
  out.ct_from_tool.translation() = found.rest_mm;

  const Eigen::Matrix3d gradient = map.GradientAt(found.rest_mm);
  const Eigen::Vector3d world_axis = ct_from_tool.linear() * axis;
  const Eigen::Matrix3d inverse = gradient.inverse();
  const Eigen::Vector3d rest_axis = inverse * world_axis;
  const double length = rest_axis.norm();
  out.axis_at_rest = out.axis_in_world = world_axis;
  // Where the field folds, directions mean nothing: then they stay.
  if (!(gradient.determinant() > 0.0) || !inverse.allFinite() || !(length > 0.0)) return out;
  const double norm = inverse.norm();
  const double share = norm > ToolAtRest::kMostPerWorld ? ToolAtRest::kMostPerWorld / norm : 1.0;
  out.rest_per_world = share * inverse;
  out.axis_at_rest = rest_axis / length;
  out.axis_per_world = share * length;
  out.world_from_rest = Eigen::Quaterniond::FromTwoVectors(rest_axis, world_axis);
  track.world_from_rest = out.world_from_rest;
  out.ct_from_tool.linear() = out.world_from_rest.conjugate() * ct_from_tool.linear();
  return out;
}

void CarryToWorld(const MotionMap& map, const ToolAtRest& tool, Eigen::Vector3d& force,
                  Eigen::Vector3d& torque) noexcept {
  const Eigen::Matrix3d world_from_rest = tool.rest_per_world.transpose();
  if (!torque.isZero(0.0)) {
    // The axis b at rest follows db = P inverse(F) (w x a - (dF/dX V) b) / |inverse(F) a|.
    constexpr double kHalfMm = 1.0;
    const Eigen::Vector3d& b = tool.axis_at_rest;
    const Eigen::Vector3d rest_mm = tool.ct_from_tool.translation();
    const Eigen::Matrix3d bends =
        (map.GradientAt(rest_mm + kHalfMm * b) - map.GradientAt(rest_mm - kHalfMm * b)) /
        (2.0 * kHalfMm);
    const Eigen::Vector3d across = world_from_rest * torque.cross(b);
    force -= bends.transpose() * across;
    torque =
        tool.axis_in_world.cross(across) / tool.axis_per_world + torque.dot(b) * tool.axis_in_world;
  }
  force = world_from_rest * force;
}

}  // namespace acus::breathing
