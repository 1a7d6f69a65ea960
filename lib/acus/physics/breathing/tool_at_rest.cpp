#include "acus/physics/breathing/tool_at_rest.h"

#include <Eigen/LU>

namespace acus::breathing {
namespace {

constexpr int kMostIterations = 4;
constexpr int kFirstIterations = 30;
constexpr double kToleranceMm = 0.002;

}  // namespace

ToolAtRest AtRest(const MotionMap& map, const Eigen::Isometry3d& ct_from_tool,
                  const Eigen::Vector3d& axis, ToolTrack& track) noexcept {
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
      map.RestOf(world_mm, start_mm,
                 {.max_iterations = track.started ? kMostIterations : kFirstIterations,
                  .tolerance_mm = kToleranceMm});
  track = {true, world_mm, found.rest_mm, Eigen::Quaterniond::Identity()};
  out.residual_mm = found.residual_mm;
  out.ct_from_tool.translation() = found.rest_mm;

  const Eigen::Matrix3d gradient = map.GradientAt(found.rest_mm);
  const Eigen::Vector3d world_axis = ct_from_tool.linear() * axis;
  const Eigen::Vector3d rest_axis = gradient.inverse() * world_axis;
  // Where the field folds, directions mean nothing: then they stay.
  if (!(gradient.determinant() > 0.0) || !rest_axis.allFinite()) return out;
  out.world_from_rest = Eigen::Quaterniond::FromTwoVectors(rest_axis, world_axis);
  track.world_from_rest = out.world_from_rest;
  out.ct_from_tool.linear() = out.world_from_rest.conjugate() * ct_from_tool.linear();
  return out;
}

}  // namespace acus::breathing
