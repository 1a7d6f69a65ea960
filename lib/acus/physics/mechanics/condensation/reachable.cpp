#include "acus/physics/mechanics/condensation/reachable.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>

#include "acus/base/core/error.h"
#include "acus/data/mesh/quality.h"
#include "acus/data/mesh/tetra_faces.h"

namespace acus::mechanics {
namespace {

using Eigen::Vector3d;

double DistanceToLine(const Vector3d& x, const Vector3d& from, const Vector3d& to) {
  const Vector3d along = to - from;
  const double length2 = along.squaredNorm();
  const double s = length2 > 0.0 ? std::clamp((x - from).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (x - from - s * along).norm();
}

/// Least distance of two straight lines of finite length (Ericson, Real-Time Collision Detection,
/// 5.1.9: minimise over one, clamp, minimise over the other, clamp again).
double DistanceOfLines(const Vector3d& p, const Vector3d& p_end, const Vector3d& q,
                       const Vector3d& q_end) {
  const Vector3d d1 = p_end - p;
  const Vector3d d2 = q_end - q;
  const double a = d1.squaredNorm();
  const double e = d2.squaredNorm();
  if (a <= 0.0) return DistanceToLine(p, q, q_end);
  if (e <= 0.0) return DistanceToLine(q, p, p_end);
  const Vector3d r = p - q;
  const double b = d1.dot(d2);
  const double c = d1.dot(r);
  const double f = d2.dot(r);
  const double denominator = a * e - b * b;
  double s =
      denominator > 1e-14 * a * e ? std::clamp((b * f - c * e) / denominator, 0.0, 1.0) : 0.0;
  const double t = (b * s + f) / e;
  if (t < 0.0) s = std::clamp(-c / a, 0.0, 1.0);
  if (t > 1.0) s = std::clamp((b - c) / a, 0.0, 1.0);
  return (r + s * d1 - std::clamp(t, 0.0, 1.0) * d2).norm();
}

/// Whether the line goes through the triangle or one of its ends projects into it; gives the
/// distance then, otherwise infinity: edges decide.
double DistanceToFace(const Vector3d& from, const Vector3d& to, const Vector3d& a,
                      const Vector3d& b, const Vector3d& c) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const Vector3d normal = (b - a).cross(c - a);
  const double twice_area = normal.norm();
  if (!(twice_area > 0.0)) return kNone;
  const double height_from = (from - a).dot(normal) / twice_area;
  const double height_to = (to - a).dot(normal) / twice_area;
  const auto projects_inside = [&](const Vector3d& x) {
    return normal.dot((b - a).cross(x - a)) >= 0.0 && normal.dot((c - b).cross(x - b)) >= 0.0 &&
           normal.dot((a - c).cross(x - c)) >= 0.0;
  };
  double least = kNone;
  if (projects_inside(from)) least = std::abs(height_from);
  if (projects_inside(to)) least = std::min(least, std::abs(height_to));
  if (height_from * height_to <= 0.0 && height_from != height_to) {
    const double s = height_from / (height_from - height_to);
    if (projects_inside(from + s * (to - from))) return 0.0;
  }
  return least;
}

bool IsInside(const Vector3d& x, const mesh::Corners& corners) {
  for (int c = 0; c < 4; ++c) {
    mesh::Corners part = corners;
    part[static_cast<std::size_t>(c)] = x;
    if (mesh::VolumeMm3(part) < 0.0) return false;
  }
  return true;
}

/// Least distance between a straight line and a tetrahedron; 0 if they have a point in common.
double DistanceToTetrahedron(const Capsule& line, const mesh::Corners& x) {
  if (IsInside(line.from_mm, x)) return 0.0;
  constexpr int kEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  constexpr int kFaces[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [a, b] : kEdges) {
    least = std::min(least, DistanceOfLines(line.from_mm, line.to_mm, x[a], x[b]));
  }
  for (const auto& [a, b, c] : kFaces) {
    least = std::min(least, DistanceToFace(line.from_mm, line.to_mm, x[a], x[b], x[c]));
  }
  return least;
}

/// Cheap bounds first: most tetrahedra are far away, or have a corner inside.
bool Touches(const Capsule& capsule, const mesh::Corners& x) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const Vector3d& corner : x) {
    nearest = std::min(nearest, DistanceToLine(corner, capsule.from_mm, capsule.to_mm));
  }
  if (nearest <= capsule.radius_mm) return true;
  double longest = 0.0;
  for (int c = 1; c < 4; ++c) longest = std::max(longest, (x[c] - x[0]).norm());
  if (nearest > capsule.radius_mm + 2.0 * longest) return false;
  return DistanceToTetrahedron(capsule, x) <= capsule.radius_mm;
}

std::string Text(const Vector3d& x) {
  return Message("(", x.x(), ", ", x.y(), ", ", x.z(), ")");
}

std::string Bounds(const mesh::TetraMesh& mesh) {
  return Message(Text(mesh.nodes_mm.rowwise().minCoeff()), " to ",
                 Text(mesh.nodes_mm.rowwise().maxCoeff()), " mm");
}

}  // namespace

std::vector<int> CorridorNodes(const mesh::TetraMesh& mesh, const FreeNodes& free,
                               const Capsule& corridor) {
  std::vector<std::uint8_t> is_reached(static_cast<std::size_t>(mesh.nodes_mm.cols()), 0);
  bool touches_any = false;
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    if (free.is_left_out[static_cast<std::size_t>(t)] ||
        !Touches(corridor, mesh::CornersOf(mesh, t))) {
      continue;
    }
    touches_any = true;
    for (const int node : mesh.tetrahedra.col(t)) is_reached[static_cast<std::size_t>(node)] = 1;
  }
  ACUS_REQUIRE(touches_any, "the corridor from ", Text(corridor.from_mm), " to ",
               Text(corridor.to_mm), " mm with radius ", corridor.radius_mm,
               " mm is outside the mesh, which reaches from ", Bounds(mesh),
               "; give its ends in CT space (LPS), one of them inside the body");
  std::vector<int> nodes;
  std::ranges::copy_if(free.mesh_node, std::back_inserter(nodes),
                       [&](int node) { return is_reached[static_cast<std::size_t>(node)] != 0; });
  ACUS_REQUIRE(!nodes.empty(), "the corridor from ", Text(corridor.from_mm), " to ",
               Text(corridor.to_mm),
               " mm touches tissue that is held in place only; put one of "
               "its ends into soft tissue");
  return nodes;
}

std::vector<int> SkinNodes(const mesh::TetraMesh& mesh, const FreeNodes& free,
                           const SkinPatch& patch) {
  const std::vector<std::uint8_t> is_outer = mesh::OuterNodes(mesh);
  std::vector<int> nodes;
  double nearest = std::numeric_limits<double>::infinity();
  for (const int node : free.mesh_node) {
    if (!is_outer[static_cast<std::size_t>(node)]) continue;
    const double distance = (mesh.nodes_mm.col(node) - patch.centre_mm).norm();
    nearest = std::min(nearest, distance);
    if (distance <= patch.radius_mm) nodes.push_back(node);
  }
  ACUS_REQUIRE(!nodes.empty(), "no skin within ", patch.radius_mm, " mm of the probe's place ",
               Text(patch.centre_mm), " mm; the nearest that can move is ", nearest,
               " mm away, the mesh reaches from ", Bounds(mesh),
               ". Move the place or choose a larger radius");
  return nodes;
}

std::vector<int> NodesInside(const mesh::TetraMesh& mesh, const FreeNodes& free,
                             const Capsule& capsule) {
  std::vector<int> nodes;
  std::ranges::copy_if(free.mesh_node, std::back_inserter(nodes), [&](int node) {
    return DistanceToLine(mesh.nodes_mm.col(node), capsule.from_mm, capsule.to_mm) <=
           capsule.radius_mm;
  });
  return nodes;
}

std::vector<int> NeedleNodes(const mesh::TetraMesh& mesh, const FreeNodes& free,
                             const Capsule& corridor, double beyond_mm) {
  const std::vector<std::uint8_t> is_outer = mesh::OuterNodes(mesh);
  const Capsule around{corridor.from_mm, corridor.to_mm, corridor.radius_mm + beyond_mm};
  std::vector<int> nodes = NodesInside(mesh, free, around);
  // Those of the surface first: a disc on it needs them, a ball has no preference.
  std::ranges::sort(nodes, {}, [&](int node) {
    const Vector3d x = mesh.nodes_mm.col(node);
    return std::tuple(is_outer[static_cast<std::size_t>(node)] == 0, x.z(), x.y(), x.x());
  });
  std::vector<int> sparse;
  for (const int node : nodes) {
    const auto is_near = [&](int other) {
      return (mesh.nodes_mm.col(other) - mesh.nodes_mm.col(node)).norm() < kSparseSpacingMm;
    };
    if (std::none_of(sparse.rbegin(), sparse.rend(), is_near)) sparse.push_back(node);
  }
  std::ranges::sort(sparse);
  return Joined(CorridorNodes(mesh, free, corridor), sparse);
}

std::vector<int> Joined(const std::vector<int>& a, const std::vector<int>& b) {
  std::vector<int> both;
  std::ranges::set_union(a, b, std::back_inserter(both));
  return both;
}

}  // namespace acus::mechanics
