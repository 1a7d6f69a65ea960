#include "acus/physics/tissue/contact_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "acus/data/mesh/quality.h"

namespace acus::tissue {
namespace {

/// Outward corner order of the faces of a tetrahedron of positive volume.
constexpr int kFaces[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

}  // namespace

ContactMesh::ContactMesh(const mesh::TetraMesh& mesh, const mechanics::Compliance& compliance)
    : location_(mesh) {
  elements_.reserve(mesh.tissue.size());
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const mesh::Corners x = mesh::CornersOf(mesh, t);
    Element element{};
    element.reachable = true;
    element.tissue = mesh.tissue[static_cast<std::size_t>(t)];
    for (int c = 0; c < 4; ++c) {
      const int node = mesh.tetrahedra(c, t);
      const bool fixed = mesh.fixed_nodes[static_cast<std::size_t>(node)] != 0;
      element.row[static_cast<std::size_t>(c)] = fixed ? -1 : compliance.RowOf(node);
      if (!fixed && element.row[static_cast<std::size_t>(c)] < 0) element.reachable = false;
    }
    const double volume_mm3 = (x[1] - x[0]).cross(x[2] - x[0]).dot(x[3] - x[0]) / 6.0;
    element.size_mm = std::cbrt(6.0 * std::numbers::sqrt2 * std::abs(volume_mm3));
    elements_.push_back(element);
  }
}

Spot ContactMesh::Find(const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
  Spot spot;
  const auto found = location_.Find(rest_in_ct_mm);
  if (!found) return spot;
  const Element& element = elements_[static_cast<std::size_t>(found->tetrahedron)];
  spot.inside = true;
  spot.reachable = element.reachable;
  spot.tissue = element.tissue;
  spot.element_mm = element.size_mm;
  for (std::size_t c = 0; c < 4; ++c) {
    const double weight = found->weights[static_cast<Eigen::Index>(c)];
    if (element.row[c] < 0 || weight == 0.0) continue;
    spot.place.row[static_cast<std::size_t>(spot.place.num_rows)] = element.row[c];
    spot.place.weight[static_cast<std::size_t>(spot.place.num_rows)] = weight;
    ++spot.place.num_rows;
  }
  return spot;
}

Eigen::Vector3d ContactMesh::Crossing(Eigen::Vector3d outside_mm,
                                      Eigen::Vector3d inside_mm) const noexcept {
  for (int halving = 0; halving < 20; ++halving) {
    const Eigen::Vector3d middle = 0.5 * (outside_mm + inside_mm);
    (location_.Find(middle) ? inside_mm : outside_mm) = middle;
  }
  return inside_mm;
}

std::vector<SurfaceNode> ReachableSurface(const mesh::TetraMesh& mesh,
                                          const mechanics::Compliance& compliance) {
  struct Face {
    int count = 0;
    std::array<int, 3> corner{};
  };
  std::map<std::array<int, 3>, Face> faces;
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    for (const auto& local : kFaces) {
      const std::array<int, 3> corner{mesh.tetrahedra(local[0], t), mesh.tetrahedra(local[1], t),
                                      mesh.tetrahedra(local[2], t)};
      if (std::ranges::none_of(corner, [&](int n) { return compliance.RowOf(n) >= 0; })) continue;
      std::array<int, 3> key = corner;
      std::ranges::sort(key);
      Face& face = faces[key];
      ++face.count;
      face.corner = corner;
    }
  }
  std::map<int, Eigen::Vector3d> normal_of_node;
  for (const auto& [key, face] : faces) {
    if (face.count != 1) continue;
    const Eigen::Vector3d a = mesh.nodes_mm.col(face.corner[0]);
    const Eigen::Vector3d b = mesh.nodes_mm.col(face.corner[1]);
    const Eigen::Vector3d c = mesh.nodes_mm.col(face.corner[2]);
    for (const int node : face.corner) {
      normal_of_node.try_emplace(node, Eigen::Vector3d::Zero());
      normal_of_node[node] += (b - a).cross(c - a);  // Weighted by area.
    }
  }
  std::vector<SurfaceNode> surface;
  for (const auto& [node, normal] : normal_of_node) {
    const int row = compliance.RowOf(node);
    if (row < 0 || !(normal.norm() > 0.0)) continue;
    surface.push_back({row, mesh.nodes_mm.col(node), -normal.normalized()});
  }
  return surface;
}

}  // namespace acus::tissue
