#include "acus/physics/mechanics/elements/strain_region.h"

#include <algorithm>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/elements/element_patches.h"

namespace acus::mechanics {
namespace {

constexpr double kSampleMm = 4.0;        // Between trial forces along the corridor.
constexpr double kOnSkinShare = 3.0;     // The first, where the skin is pressed, over the others.
constexpr std::size_t kTrialNodes = 12;  // That share a trial force.

/// Nodes of the compliance near the corridor, by how far along it they are: depth, row.
std::vector<std::pair<double, int>> NodesAlong(const mesh::TetraMesh& mesh,
                                               const Compliance& compliance, const Capsule& line) {
  std::vector<std::pair<double, int>> out;
  const Eigen::Vector3d along = (line.to_mm - line.from_mm).normalized();
  for (int row = 0; row < compliance.num_nodes(); ++row) {
    const Eigen::Vector3d off =
        mesh.nodes_mm.col(compliance.nodes()[static_cast<std::size_t>(row)]) - line.from_mm;
    const double depth_mm = off.dot(along);
    if ((off - depth_mm * along).norm() <= line.radius_mm) out.emplace_back(depth_mm, row);
  }
  std::ranges::sort(out);
  return out;
}

/// Displacements of all nodes of the mesh by a force along the corridor, spread over the nodes of
/// the compliance that are nearest to a place, per N; 0 where the compliance has no row.
Eigen::Matrix3Xd MovedByTrial(const mesh::TetraMesh& mesh, const Compliance& compliance,
                              const Eigen::Vector3d& place_mm, const Eigen::Vector3d& along) {
  std::vector<std::pair<double, int>> nearest;
  for (int row = 0; row < compliance.num_nodes(); ++row) {
    const int node = compliance.nodes()[static_cast<std::size_t>(row)];
    nearest.emplace_back((mesh.nodes_mm.col(node) - place_mm).norm(), row);
  }
  const std::size_t count = std::min(kTrialNodes, nearest.size());
  std::ranges::partial_sort(nearest, nearest.begin() + static_cast<std::ptrdiff_t>(count));
  Eigen::Matrix3Xd u = Eigen::Matrix3Xd::Zero(3, mesh.nodes_mm.cols());
  for (int row = 0; row < compliance.num_nodes(); ++row) {
    const int node = compliance.nodes()[static_cast<std::size_t>(row)];
    for (int axis = 0; axis < 3; ++axis) {
      for (std::size_t n = 0; n < count; ++n) {
        for (int d = 0; d < 3; ++d) {
          u(axis, node) += along[d] / static_cast<double>(count) *
                           compliance.At(3 * row + axis, 3 * nearest[n].second + d);
        }
      }
    }
  }
  return u;
}

/// Raises each patch's score to the largest strain in it.
void RaiseScores(const mesh::TetraMesh& mesh, const std::vector<ElementPatch>& patches,
                 const Eigen::Matrix3Xd& u, double share, std::vector<double>& score) {
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (score[p] < 0.0) continue;
    for (const int t : patches[p].tetrahedra) {
      const LinearTetrahedron shape = LinearTetrahedronOf(mesh, t);
      Eigen::Matrix3d gradient = Eigen::Matrix3d::Zero();
      for (int c = 0; c < 4; ++c) {
        gradient += u.col(mesh.tetrahedra(c, t)) * shape.gradients_per_mm.col(c).transpose();
      }
      score[p] = std::max(score[p], share * gradient.norm());
    }
  }
}

/// Patches that the compliance holds as a whole, the most strained by trial forces along the
/// corridor first.
std::vector<int> PatchesInReach(const mesh::TetraMesh& mesh,
                                const std::vector<ElementPatch>& patches,
                                const Compliance& compliance, const Capsule& line) {
  std::vector<double> score(patches.size(), 0.0);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    for (const int node : patches[p].nodes) {
      const bool held = mesh.fixed_nodes[static_cast<std::size_t>(node)] != 0;
      if (!held && compliance.RowOf(node) < 0) score[p] = -1.0;
    }
  }
  const std::vector<std::pair<double, int>> nodes = NodesAlong(mesh, compliance, line);
  if (nodes.empty()) return {};
  const Eigen::Vector3d along = (line.to_mm - line.from_mm).normalized();
  const double first_mm = nodes.front().first;
  for (double depth_mm = first_mm; depth_mm <= nodes.back().first; depth_mm += kSampleMm) {
    const Eigen::Matrix3Xd u =
        MovedByTrial(mesh, compliance, line.from_mm + depth_mm * along, along);
    RaiseScores(mesh, patches, u, depth_mm == first_mm ? kOnSkinShare : 1.0, score);
  }
  std::vector<std::pair<double, int>> order;
  for (std::size_t p = 0; p < patches.size(); ++p) {
    if (score[p] > 0.0) order.emplace_back(-score[p], static_cast<int>(p));
  }
  std::ranges::sort(order);
  std::vector<int> out;
  for (const auto& [minus_score, p] : order) out.push_back(p);
  return out;
}

}  // namespace

StrainRegion::StrainRegion(const mesh::TetraMesh& mesh, const ElasticityTable& table,
                           ElementKind kind, const Compliance& compliance, const Capsule& line,
                           int max_nodes)
    : index_of_row_(static_cast<std::size_t>(compliance.num_nodes()), -1) {
  const FreeNodes free = FindFreeNodes(mesh);
  const std::vector<ElementPatch> patches = ElementPatches(mesh, kind, free.is_left_out);
  std::vector<int> chosen;
  std::vector<int> added;
  for (const int p : PatchesInReach(mesh, patches, compliance, line)) {
    added.clear();
    for (const int node : patches[static_cast<std::size_t>(p)].nodes) {
      const int row = compliance.RowOf(node);
      if (row >= 0 && index_of_row_[static_cast<std::size_t>(row)] < 0) added.push_back(row);
    }
    if (rows_.size() + added.size() > static_cast<std::size_t>(max_nodes)) break;
    for (const int row : added) {
      index_of_row_[static_cast<std::size_t>(row)] = 0;
      rows_.push_back(row);
    }
    chosen.push_back(p);
  }
  std::ranges::sort(rows_);
  std::ranges::sort(chosen);
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    index_of_row_[static_cast<std::size_t>(rows_[i])] = static_cast<int>(i);
  }
  std::vector<int> index_of_node(static_cast<std::size_t>(mesh.nodes_mm.cols()), num_nodes());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const int node = compliance.nodes()[static_cast<std::size_t>(rows_[i])];
    index_of_node[static_cast<std::size_t>(node)] = static_cast<int>(i);
  }
  for (const int p : chosen) {
    body_.Add(mesh, table, patches[static_cast<std::size_t>(p)], index_of_node);
  }
}

void StrainRegion::MissingForces(const Eigen::Ref<const Eigen::Matrix3Xd>& u_mm, Scratch& scratch,
                                 Eigen::Ref<Eigen::Matrix3Xd> out_n) const noexcept {
  out_n.setZero();
  DeformAll(body_, u_mm, scratch);
  AddMissingForces(body_, scratch, out_n);
}

}  // namespace acus::mechanics
