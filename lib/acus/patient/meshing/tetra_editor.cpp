#include "acus/patient/meshing/tetra_editor.h"

#include <algorithm>

#include "acus/base/core/error.h"

namespace acus::meshing {

TetraEditor::TetraEditor(const Eigen::Matrix3Xd& nodes_mm, const Eigen::Matrix4Xi& tetrahedra)
    : nodes_(nodes_mm.cols()), star_(nodes_mm.cols()) {
  for (Eigen::Index n = 0; n < nodes_mm.cols(); ++n) nodes_[n] = nodes_mm.col(n);
  tetrahedra_.reserve(tetrahedra.cols());
  material_.reserve(tetrahedra.cols());
  for (Eigen::Index t = 0; t < tetrahedra.cols(); ++t) {
    Add({tetrahedra(0, t), tetrahedra(1, t), tetrahedra(2, t), tetrahedra(3, t)}, 0);
  }
}

int TetraEditor::AddNode(const Eigen::Vector3d& x) {
  nodes_.push_back(x);
  star_.emplace_back();
  return num_nodes() - 1;
}

int TetraEditor::Add(const Tetrahedron& corners, std::uint8_t material) {
  int t = num_slots();
  if (free_.empty()) {
    tetrahedra_.push_back(corners);
    material_.push_back(material);
  } else {
    t = free_.back();
    free_.pop_back();
    tetrahedra_[t] = corners;
    material_[t] = material;
  }
  for (const int n : corners) {
    auto& star = star_[n];
    star.insert(std::ranges::upper_bound(star, t), t);
  }
  return t;
}

void TetraEditor::Remove(int t) {
  ACUS_ASSERT(is_alive(t));
  for (const int n : tetrahedra_[t]) {
    auto& star = star_[n];
    star.erase(std::ranges::lower_bound(star, t));
  }
  tetrahedra_[t] = {-1, -1, -1, -1};
  free_.push_back(t);
}

mesh::Corners TetraEditor::CornersOf(const Tetrahedron& c) const {
  return {nodes_[c[0]], nodes_[c[1]], nodes_[c[2]], nodes_[c[3]]};
}

double TetraEditor::Score(const Tetrahedron& corners, std::uint8_t material) const {
  const mesh::Corners x = CornersOf(corners);
  if (material != 0) return mesh::DihedralScore(x);
  return mesh::VolumeMm3(x) > 1e-6 ? 0.0 : -2.0;
}

double TetraEditor::StarScore(int n) const {
  double least = 0.0;
  for (const int t : star_[n]) least = std::min(least, Score(t));
  return least;
}

std::vector<int> TetraEditor::AtEdge(int a, int b) const {
  std::vector<int> out;
  std::ranges::set_intersection(star_[a], star_[b], std::back_inserter(out));
  return out;
}

bool TetraEditor::Has(int t, int n) const {
  const Tetrahedron& c = tetrahedra_[t];
  return c[0] == n || c[1] == n || c[2] == n || c[3] == n;
}

int TetraEditor::Neighbour(int t, int c) const {
  const Tetrahedron& corners = tetrahedra_[t];
  const int a = corners[(c + 1) & 3];
  const int b = corners[(c + 2) & 3];
  const int d = corners[(c + 3) & 3];
  for (const int other : star_[a]) {
    if (other != t && Has(other, b) && Has(other, d)) return other;
  }
  return -1;
}

std::vector<int> TetraEditor::NodesAround(int n) const {
  std::vector<int> out;
  out.reserve(3 * star_[n].size());
  for (const int t : star_[n]) {
    for (const int other : tetrahedra_[t]) {
      if (other != n) out.push_back(other);
    }
  }
  std::ranges::sort(out);
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

std::vector<std::uint8_t> TetraEditor::MaterialsAt(int n) const {
  std::vector<std::uint8_t> out;
  for (const int t : star_[n]) {
    const auto place = std::ranges::lower_bound(out, material_[t]);
    if (place == out.end() || *place != material_[t]) out.insert(place, material_[t]);
  }
  return out;
}

int TetraEditor::SplitEdge(int a, int b, const Eigen::Vector3d& x) {
  const std::vector<int> ring = AtEdge(a, b);
  const int middle = AddNode(x);
  for (const int t : ring) {
    Tetrahedron first = tetrahedra_[t];
    Tetrahedron second = first;
    const std::uint8_t material = material_[t];
    std::ranges::replace(first, b, middle);
    std::ranges::replace(second, a, middle);
    Remove(t);
    Add(first, material);
    Add(second, material);
  }
  return middle;
}

}  // namespace acus::meshing
