#include "acus/physics/tissue/fem_field.h"

#include <algorithm>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::tissue {
namespace {

constexpr int kHeld = -1;
constexpr int kOutOfReach = -2;
/// Weights below this are rounding: a load at a node or on a face acts on no other node.
constexpr double kLeastWeight = 1e-9;
constexpr int kColumnsAtOnce = 8;
constexpr double kTetrahedraPerCell = 0.25;  ///< Thousands of places are looked up per image.

/// Place of each mesh node in a list of nodes; `without` where it is in none.
std::vector<int> RowsOf(std::span<const int> nodes, Eigen::Index num_mesh_nodes, int without) {
  std::vector<int> row(static_cast<std::size_t>(num_mesh_nodes), without);
  for (std::size_t r = 0; r < nodes.size(); ++r) row[nodes[r]] = static_cast<int>(r);
  return row;
}

/// The tetrahedra with one of the nodes that are stored, in the order of the mesh.
mesh::TetraMesh StoredPart(const mesh::TetraMesh& mesh, const mechanics::ImageBlock& image) {
  ACUS_REQUIRE(image.num_nodes() > 0,
               "the compliance file holds no displacements for the image; make it again with "
               "acus-mesh --condense and \"image_radius_mm\" above 0");
  ACUS_ASSERT(image.nodes().back() < mesh.nodes_mm.cols());
  const std::vector<int> row = RowsOf(image.nodes(), mesh.nodes_mm.cols(), -1);
  std::vector<int> kept;
  for (int t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const auto corners = mesh.tetrahedra.col(t);
    if (std::ranges::any_of(corners, [&](int node) { return row[node] >= 0; })) kept.push_back(t);
  }
  return {mesh.nodes_mm, mesh.tetrahedra(Eigen::all, kept), {}, mesh.fixed_nodes};
}

/// Nodes of tetrahedra only, so that the grid of PointLocation covers no more than needed.
mesh::TetraMesh WithoutSpareNodes(mesh::TetraMesh mesh) {
  std::vector<int> number(static_cast<std::size_t>(mesh.nodes_mm.cols()), -1);
  std::vector<int> kept;
  for (int& node : mesh.tetrahedra.reshaped()) {
    if (number[node] < 0) {
      number[node] = static_cast<int>(kept.size());
      kept.push_back(node);
    }
    node = number[node];
  }
  mesh.nodes_mm = Eigen::Matrix3Xd(mesh.nodes_mm(Eigen::all, kept));
  return mesh;
}

/// out += sum of force[k] * column[k]. Element by element, so that vector instructions of any width
/// give the same bits.
void AddColumns(const std::array<const float*, kColumnsAtOnce>& column,
                const std::array<float, kColumnsAtOnce>& force, int size, float* out) noexcept {
  for (int i = 0; i < size; ++i) {
    const float even = (column[0][i] * force[0] + column[2][i] * force[2]) +
                       (column[4][i] * force[4] + column[6][i] * force[6]);
    const float odd = (column[1][i] * force[1] + column[3][i] * force[3]) +
                      (column[5][i] * force[5] + column[7][i] * force[7]);
    out[i] += even + odd;
  }
}

}  // namespace

FemImage::FemImage(const mesh::TetraMesh& mesh, mechanics::CondensedTissue tissue)
    : tissue_(std::move(tissue)),
      location_(WithoutSpareNodes(StoredPart(mesh, tissue_.image)), kTetrahedraPerCell) {
  const mesh::TetraMesh part = StoredPart(mesh, tissue_.image);
  const std::vector<int> image_row = RowsOf(tissue_.image.nodes(), mesh.nodes_mm.cols(), -1);
  std::vector<int> reach_row =
      RowsOf(tissue_.compliance.nodes(), mesh.nodes_mm.cols(), kOutOfReach);
  for (std::size_t node = 0; node < reach_row.size(); ++node) {
    if (mesh.fixed_nodes[node]) reach_row[node] = kHeld;
  }
  elements_.resize(static_cast<std::size_t>(part.tetrahedra.cols()));
  for (std::size_t t = 0; t < elements_.size(); ++t) {
    for (int c = 0; c < 4; ++c) {
      const int node = part.tetrahedra(c, static_cast<Eigen::Index>(t));
      elements_[t].image_row[c] = image_row[node];
      elements_[t].reach_row[c] = reach_row[node];
    }
  }
}

FemField::FemField(const FemImage& image)
    : image_(&image),
      force_n_(3 * static_cast<std::size_t>(image.tissue_.compliance.num_nodes()), 0.0),
      displacement_mm_(3 * static_cast<std::size_t>(image.tissue_.image.num_nodes()), 0.0f) {
  loaded_.reserve(4 * TissueLoad::kMaxPoints);
}

void FemField::AddLoad(const PointLoad& load) noexcept {
  const auto found = image_->location_.Find(load.rest_in_ct_mm);
  if (!found || !load.force_in_ct_n.allFinite()) {
    ++num_dropped_;
    return;
  }
  const FemImage::Element& element = image_->elements_[found->tetrahedron];
  for (int c = 0; c < 4; ++c) {
    if (found->weights[c] > kLeastWeight && element.reach_row[c] == kOutOfReach) {
      ++num_dropped_;
      return;
    }
  }
  for (int c = 0; c < 4; ++c) {
    const int row = element.reach_row[c];
    if (row < 0 || found->weights[c] <= kLeastWeight) continue;
    loaded_.push_back(row);
    for (int axis = 0; axis < 3; ++axis) {
      force_n_[3 * row + axis] += found->weights[c] * load.force_in_ct_n[axis];
    }
  }
}

void FemField::Update(const TissueLoad& load) noexcept {
  for (const int row : loaded_) std::fill_n(&force_n_[3 * row], 3, 0.0);
  loaded_.clear();
  num_dropped_ = 0;
  for (int p = 0; p < std::min(load.num_points, TissueLoad::kMaxPoints); ++p) {
    if (load.point[p].force_in_ct_n != Eigen::Vector3d::Zero()) AddLoad(load.point[p]);
  }
  // Ascending, so that the order of the loads hardly changes the bits.
  std::ranges::sort(loaded_);
  loaded_.erase(std::unique(loaded_.begin(), loaded_.end()), loaded_.end());
  is_zero_ = true;
  std::ranges::fill(displacement_mm_, 0.0f);
  std::array<const float*, kColumnsAtOnce> column{};
  std::array<float, kColumnsAtOnce> force{};
  const mechanics::ImageBlock& block = image_->tissue_.image;
  int count = 0;
  const auto flush = [&] {
    // Columns that are missing to a full set count nothing.
    for (int k = count; k < kColumnsAtOnce; ++k) {
      column[k] = column[0];
      force[k] = 0.0f;
    }
    if (count > 0) {
      AddColumns(column, force, static_cast<int>(displacement_mm_.size()), displacement_mm_.data());
    }
    count = 0;
  };
  for (const int row : loaded_) {
    for (int dof = 3 * row; dof < 3 * row + 3; ++dof) {
      if (force_n_[dof] == 0.0) continue;
      is_zero_ = false;
      column[count] = block.Column(dof);
      force[count] = static_cast<float>(force_n_[dof]);
      if (++count == kColumnsAtOnce) flush();
    }
  }
  flush();
}

Eigen::Vector3d FemField::DisplacementMm(const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  if (is_zero_) return sum;
  const auto found = image_->location_.Find(rest_in_ct_mm);
  if (!found) return sum;
  const FemImage::Element& element = image_->elements_[found->tetrahedron];
  for (int c = 0; c < 4; ++c) {
    if (element.image_row[c] < 0) continue;
    const float* u = &displacement_mm_[3 * static_cast<std::size_t>(element.image_row[c])];
    sum += found->weights[c] * Eigen::Vector3d(u[0], u[1], u[2]);
  }
  return sum;
}

}  // namespace acus::tissue
