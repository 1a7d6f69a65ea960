#include "mechanics/stiffness.h"

#include <algorithm>
#include <vector>

#include "mechanics/block_matrix.h"
#include "mechanics/dilatation_patches.h"
#include "mechanics/linear_tetrahedron.h"

namespace acus::mechanics {
namespace {

std::vector<int> Resisting(const mesh::TetraMesh& mesh, std::span<const std::uint8_t> is_left_out) {
  std::vector<int> out;
  for (int t = 0; t < mesh.tetrahedra.cols(); ++t) {
    if (!is_left_out.empty() && is_left_out[t]) continue;
    bool moves = mesh.fixed_nodes.empty();
    for (int c = 0; c < 4 && !moves; ++c) moves = !mesh.fixed_nodes[mesh.tetrahedra(c, t)];
    if (moves) out.push_back(t);
  }
  return out;
}

std::vector<std::vector<int>> Patches(const mesh::TetraMesh& mesh, ElementKind kind,
                                      const std::vector<int>& resisting) {
  if (kind == ElementKind::kAveragedDilatation) return DilatationPatches(mesh, resisting);
  std::vector<std::vector<int>> single;
  single.reserve(resisting.size());
  for (const int t : resisting) single.push_back({t});
  return single;
}

std::vector<int> NodesOf(const mesh::TetraMesh& mesh, const std::vector<int>& patch) {
  std::vector<int> nodes;
  for (const int t : patch) {
    for (const int node : mesh.tetrahedra.col(t)) nodes.push_back(node);
  }
  std::ranges::sort(nodes);
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

/// Adds the stiffness of one patch: each tetrahedron against change of shape, all together against
/// the mean change of volume, K V mean^2 / 2 with V mean = b u.
void AddPatch(const mesh::TetraMesh& mesh, const ElasticTissue& tissue,
              const std::vector<int>& patch, const std::vector<int>& nodes, BlockMatrix& matrix) {
  const auto size = static_cast<Eigen::Index>(3 * nodes.size());
  Eigen::VectorXd volume_gradient_mm2 = Eigen::VectorXd::Zero(size);
  double volume_mm3 = 0.0;
  for (const int t : patch) {
    const LinearTetrahedron element = LinearTetrahedronOf(mesh, t);
    const Eigen::Vector4i corners = mesh.tetrahedra.col(t);
    matrix.Add({corners.data(), 4}, DeviatoricStiffness(element, tissue.ShearModulusMpa()));
    const Eigen::Matrix<double, 12, 1> b = VolumeGradientMm2(element);
    for (int c = 0; c < 4; ++c) {
      const auto at = std::ranges::lower_bound(nodes, corners[c]) - nodes.begin();
      volume_gradient_mm2.segment<3>(3 * at) += b.segment<3>(3 * c);
    }
    volume_mm3 += element.volume_mm3;
  }
  matrix.Add(nodes, tissue.BulkModulusMpa() / volume_mm3 * volume_gradient_mm2 *
                        volume_gradient_mm2.transpose());
}

}  // namespace

Eigen::SparseMatrix<double> AssembleStiffness(const mesh::TetraMesh& mesh,
                                              const ElasticityTable& table, ElementKind kind,
                                              std::span<const std::uint8_t> is_left_out) {
  const std::vector<int> resisting = Resisting(mesh, is_left_out);
  const std::vector<std::vector<int>> patches = Patches(mesh, kind, resisting);
  std::vector<std::vector<int>> nodes;
  nodes.reserve(patches.size());
  for (const std::vector<int>& patch : patches) nodes.push_back(NodesOf(mesh, patch));
  BlockMatrix matrix(static_cast<int>(mesh.nodes_mm.cols()), nodes);
  for (std::size_t p = 0; p < patches.size(); ++p) {
    AddPatch(mesh, table.At(mesh.tissue[patches[p][0]]), patches[p], nodes[p], matrix);
  }
  return std::move(matrix).Take();
}

Eigen::SparseMatrix<double> FreeStiffness(const Eigen::SparseMatrix<double>& lower_n_per_mm,
                                          const FreeNodes& free) {
  std::vector<int> row_of_dof(static_cast<std::size_t>(lower_n_per_mm.rows()), -1);
  for (std::size_t r = 0; r < free.mesh_node.size(); ++r) {
    for (int axis = 0; axis < 3; ++axis) {
      row_of_dof[3 * free.mesh_node[r] + axis] = static_cast<int>(3 * r) + axis;
    }
  }
  Eigen::SparseMatrix<double> out(free.num_dofs(), free.num_dofs());
  std::vector<int> per_column(static_cast<std::size_t>(free.num_dofs()), 0);
  for (int column = 0; column < lower_n_per_mm.cols(); ++column) {
    if (row_of_dof[column] < 0) continue;
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower_n_per_mm, column); it; ++it) {
      per_column[row_of_dof[column]] += row_of_dof[it.row()] >= 0;
    }
  }
  out.reserve(per_column);
  for (int column = 0; column < lower_n_per_mm.cols(); ++column) {
    if (row_of_dof[column] < 0) continue;
    for (Eigen::SparseMatrix<double>::InnerIterator it(lower_n_per_mm, column); it; ++it) {
      const int row = row_of_dof[it.row()];
      if (row >= 0) out.insert(row, row_of_dof[column]) = it.value();
    }
  }
  out.makeCompressed();
  return out;
}

}  // namespace acus::mechanics
