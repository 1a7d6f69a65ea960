#include "acus/patient/meshing/body_mesh.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/data/mesh/quality.h"

namespace acus::meshing {

std::size_t NumBodyNodes(const TetraEditor& editor) {
  std::size_t count = 0;
  for (int n = 0; n < editor.num_nodes(); ++n) {
    count += std::ranges::any_of(editor.star(n), [&](int t) { return editor.material(t) != 0; });
  }
  return count;
}

double DropIslands(double min_share, TetraEditor& editor) {
  std::vector<int> island(editor.num_slots(), -1);
  std::vector<double> volume;
  for (int seed = 0; seed < editor.num_slots(); ++seed) {
    if (!editor.is_alive(seed) || editor.material(seed) == 0 || island[seed] >= 0) continue;
    std::vector<int> open{seed};
    island[seed] = static_cast<int>(volume.size());
    volume.push_back(0.0);
    while (!open.empty()) {
      const int t = open.back();
      open.pop_back();
      volume.back() += mesh::VolumeMm3(editor.CornersOf(editor.tetrahedron(t)));
      for (int c = 0; c < 4; ++c) {
        const int other = editor.Neighbour(t, c);
        if (other < 0 || editor.material(other) == 0 || island[other] >= 0) continue;
        island[other] = island[seed];
        open.push_back(other);
      }
    }
  }
  ACUS_REQUIRE(!volume.empty(), "the body is smaller than the elements; choose smaller ones");
  const double limit = min_share * std::accumulate(volume.begin(), volume.end(), 0.0);
  double dropped_ml = 0.0;
  for (int t = 0; t < editor.num_slots(); ++t) {
    if (editor.is_alive(t) && island[t] >= 0 && volume[island[t]] < limit) {
      dropped_ml += mesh::VolumeMm3(editor.CornersOf(editor.tetrahedron(t))) / 1000.0;
      editor.set_material(t, 0);
    }
  }
  return dropped_ml;
}

mesh::TetraMesh BodyOf(const TetraEditor& editor, const volume::Geometry& geometry,
                       Eigen::Matrix3Xd& in_grid_mm) {
  std::vector<int> number(editor.num_nodes(), -1);
  std::vector<int> kept;
  std::vector<int> nodes;
  for (int t = 0; t < editor.num_slots(); ++t) {
    if (!editor.is_alive(t) || editor.material(t) == 0) continue;
    kept.push_back(t);
    for (const int n : editor.tetrahedron(t)) number[n] = 0;
  }
  for (int n = 0; n < editor.num_nodes(); ++n) {
    if (number[n] < 0) continue;
    number[n] = static_cast<int>(nodes.size());
    nodes.push_back(n);
  }
  mesh::TetraMesh mesh;
  in_grid_mm.resize(3, static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t n = 0; n < nodes.size(); ++n) in_grid_mm.col(n) = editor.node(nodes[n]);
  const Eigen::Matrix3d& direction = geometry.direction;
  mesh.nodes_mm = (direction * in_grid_mm).colwise() + geometry.origin_mm;
  mesh.tetrahedra.resize(4, static_cast<Eigen::Index>(kept.size()));
  const bool is_mirrored = direction.determinant() < 0.0;
  for (std::size_t t = 0; t < kept.size(); ++t) {
    for (int c = 0; c < 4; ++c) mesh.tetrahedra(c, t) = number[editor.tetrahedron(kept[t])[c]];
    if (is_mirrored) std::swap(mesh.tetrahedra(0, t), mesh.tetrahedra(1, t));
    mesh.tissue.push_back(editor.material(kept[t]));
  }
  return mesh;
}

}  // namespace acus::meshing
