#include "needle/curved_path.h"

#include <algorithm>
#include <cmath>

namespace acus::needle {

using Eigen::Vector3d;

void CurvedPath::Begin(const PathNode& at) noexcept {
  num_nodes = 1;
  node[0] = at;
  node[0].depth_mm = 0.0;
}

void CurvedPath::Advance(const Vector3d& direction, double distance_mm,
                         const PathNode& tissue) noexcept {
  const double norm = direction.norm();
  if (empty() || !(distance_mm > 0.0) || !std::isfinite(distance_mm) || !(norm > 0.0) ||
      !std::isfinite(norm)) {
    return;
  }
  PathNode tip_node = tissue;
  tip_node.position_mm = tip().position_mm + distance_mm / norm * direction;
  if (num_nodes == 1) ++num_nodes;  // The first node stays on the skin.
  const auto length = [&] {
    return (tip_node.position_mm - node[num_nodes - 2].position_mm).norm();
  };
  while (length() > 1.5 * spacing_mm && num_nodes < kMaxNodes) {
    const PathNode& before = node[num_nodes - 2];
    PathNode& placed = node[num_nodes - 1];
    placed = tissue;
    placed.position_mm =
        before.position_mm + spacing_mm / length() * (tip_node.position_mm - before.position_mm);
    placed.depth_mm = before.depth_mm + spacing_mm;
    ++num_nodes;
  }
  tip_node.depth_mm = node[num_nodes - 2].depth_mm + length();
  node[num_nodes - 1] = tip_node;
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
      // Near the node before, that one goes: the tip takes its place, on the piece behind it.
      if (left_mm < 0.5 * spacing_mm && num_nodes > 2) {
        const PathNode tip_node = last;
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

double CurvedPath::StiffnessNPerMm2(double depth_mm) const noexcept {
  // The tissue of the piece that ends at the next node.
  return num_nodes < 2 ? node[0].stiffness_n_per_mm2
                       : node[PieceAt(depth_mm) + 1].stiffness_n_per_mm2;
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
