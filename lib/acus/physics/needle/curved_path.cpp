#include "acus/physics/needle/curved_path.h"

#include <algorithm>
#include <cmath>

namespace acus::needle {

using Eigen::Vector3d;

void CurvedPath::Begin(const PathNode& at) noexcept {
  num_nodes = 1;
  node[0] = at;
  node[0].depth_mm = node[0].support_n_per_mm = 0.0;
}

void CurvedPath::Advance(const Vector3d& direction, double distance_mm,
                         const PathNode& tissue) noexcept {
  const double norm = direction.norm();
  if (empty() || !(distance_mm > 0.0) || !std::isfinite(distance_mm) || !(norm > 0.0) ||
      !std::isfinite(norm)) {
    return;
  }
  // In short steps, so that a corner is cut by less than a spacing. Far beyond the last node that
  // there is room for, one step does.
  const Vector3d unit = direction / norm;
  const double reach_mm = std::min(distance_mm, kMaxNodes * spacing_mm);
  const int steps = static_cast<int>(std::ceil(reach_mm / (0.4 * spacing_mm)));
  for (int i = 0; i < steps; ++i) StepForward(unit, reach_mm / steps, tissue);
  if (distance_mm > reach_mm) StepForward(unit, distance_mm - reach_mm, tissue);
}

void CurvedPath::StepForward(const Vector3d& unit, double step_mm,
                             const PathNode& tissue) noexcept {
  PathNode moved = tissue;
  moved.position_mm = tip().position_mm + step_mm * unit;
  moved.support_n_per_mm = tip().support_n_per_mm + step_mm * tissue.stiffness_n_per_mm2;
  if (num_nodes == 1) node[num_nodes++] = node[0];  // The first node stays on the skin.
  const PathNode& before = node[num_nodes - 2];
  const Vector3d piece_mm = moved.position_mm - before.position_mm;
  double length_mm = piece_mm.norm();
  const double passed_mm = tip().depth_mm - before.depth_mm;
  if (passed_mm < spacing_mm) {
    const double gained_mm = length_mm - passed_mm;
    const double share =
        gained_mm > 0.0 ? std::min(1.0, (spacing_mm - passed_mm) / gained_mm) : 1.0;
    support_at_spacing_n_per_mm =
        tip().support_n_per_mm + share * (moved.support_n_per_mm - tip().support_n_per_mm);
  }
  if (length_mm > 1.5 * spacing_mm && num_nodes < kMaxNodes) {
    PathNode& placed = node[num_nodes - 1];
    placed = tissue;
    placed.position_mm = before.position_mm + spacing_mm / length_mm * piece_mm;
    placed.depth_mm = before.depth_mm + spacing_mm;
    placed.support_n_per_mm = support_at_spacing_n_per_mm;
    ++num_nodes;
    length_mm -= spacing_mm;
  }
  moved.depth_mm = node[num_nodes - 2].depth_mm + length_mm;
  node[num_nodes - 1] = moved;
}

void CurvedPath::Retract(double distance_mm) noexcept {
  if (!(distance_mm > 0.0)) return;
  while (num_nodes > 1) {
    PathNode& last = node[num_nodes - 1];
    const PathNode& before = node[num_nodes - 2];
    const double piece_mm = last.depth_mm - before.depth_mm;
    const double left_mm = piece_mm - distance_mm;
    if (left_mm > 0.0) {
      last.position_mm =
          before.position_mm + left_mm / piece_mm * (last.position_mm - before.position_mm);
      last.depth_mm = before.depth_mm + left_mm;
      last.support_n_per_mm =
          before.support_n_per_mm +
          left_mm / piece_mm * (last.support_n_per_mm - before.support_n_per_mm);
      // Near the node before, that one goes: the tip takes its place, on the piece behind it.
      if (left_mm < 0.5 * spacing_mm && num_nodes > 2) {
        const PathNode tip_node = last;
        support_at_spacing_n_per_mm = before.support_n_per_mm;
        --num_nodes;
        PathNode& end = node[num_nodes - 1];
        const Vector3d behind_mm = node[num_nodes - 2].position_mm;
        end = tip_node;
        end.depth_mm = node[num_nodes - 2].depth_mm + (tip_node.position_mm - behind_mm).norm();
      }
      return;
    }
    distance_mm -= piece_mm;
    --num_nodes;
  }
  num_nodes = 0;
}

int CurvedPath::PieceAt(double depth_mm) const noexcept {
  // The first node that is deeper, less one; within the first and last piece.
  const auto* begin = node.begin();
  const auto* deeper =
      std::upper_bound(begin, begin + num_nodes, depth_mm,
                       [](double depth, const PathNode& at) { return depth < at.depth_mm; });
  return std::clamp(static_cast<int>(deeper - begin) - 1, 0, std::max(0, num_nodes - 2));
}

Vector3d CurvedPath::Direction(double depth_mm, const Vector3d& fallback) const noexcept {
  if (num_nodes < 2) return fallback;
  const int i = PieceAt(depth_mm);
  const Vector3d piece_mm = node[i + 1].position_mm - node[i].position_mm;
  const double norm = piece_mm.norm();
  return norm > 0.0 ? Vector3d(piece_mm / norm) : fallback;
}

Vector3d CurvedPath::PositionMm(double depth_mm) const noexcept {
  const int i = PieceAt(depth_mm);
  return node[i].position_mm +
         (depth_mm - node[i].depth_mm) * Direction(depth_mm, Vector3d::Zero());
}

double CurvedPath::SupportNPerMm(double depth_mm) const noexcept {
  if (num_nodes < 2 || !(depth_mm > 0.0)) return 0.0;
  if (depth_mm >= tip().depth_mm) return tip().support_n_per_mm;
  const int i = PieceAt(depth_mm);
  const double piece_mm = node[i + 1].depth_mm - node[i].depth_mm;
  const double share = piece_mm > 0.0 ? (depth_mm - node[i].depth_mm) / piece_mm : 0.0;
  return node[i].support_n_per_mm +
         share * (node[i + 1].support_n_per_mm - node[i].support_n_per_mm);
}

BevelTip::Heading BevelTip::After(double distance_mm, const Vector3d& heading,
                                  const Vector3d& tip_x, const Vector3d& tip_y) const noexcept {
  const Vector3d t = heading.normalized();
  Vector3d side = std::cos(roll_rad) * tip_x + std::sin(roll_rad) * tip_y;
  side -= side.dot(t) * t;
  const double norm = side.norm();
  const double turn_rad = curvature_per_mm * distance_mm;
  if (!(norm > 1e-9) || turn_rad == 0.0) return {t, t};
  side /= norm;
  return {std::cos(turn_rad) * t + std::sin(turn_rad) * side,
          std::cos(0.5 * turn_rad) * t + std::sin(0.5 * turn_rad) * side};
}

}  // namespace acus::needle
