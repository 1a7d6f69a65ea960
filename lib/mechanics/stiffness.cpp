#include "mechanics/stiffness.h"

#include <vector>

#include "core/error.h"
#include "mechanics/block_matrix.h"
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

}  // namespace

Eigen::SparseMatrix<double> AssembleStiffness(const mesh::TetraMesh& mesh,
                                              const ElasticityTable& table, ElementKind kind,
                                              std::span<const std::uint8_t> is_left_out) {
  ACUS_ASSERT(kind == ElementKind::kLinear);
  const std::vector<int> resisting = Resisting(mesh, is_left_out);
  std::vector<std::vector<int>> nodes;
  nodes.reserve(resisting.size());
  for (const int t : resisting) {
    const auto corners = mesh.tetrahedra.col(t);
    nodes.push_back({corners[0], corners[1], corners[2], corners[3]});
  }
  BlockMatrix matrix(static_cast<int>(mesh.nodes_mm.cols()), nodes);
  for (std::size_t i = 0; i < resisting.size(); ++i) {
    const int t = resisting[i];
    const ElasticTissue& tissue = table.At(mesh.tissue[t]);
    const LinearTetrahedron element = LinearTetrahedronOf(mesh, t);
    const Eigen::Matrix<double, 12, 1> b = VolumeGradientMm2(element);
    TetrahedronMatrix k = DeviatoricStiffness(element, tissue.ShearModulusMpa());
    k += tissue.BulkModulusMpa() / element.volume_mm3 * b * b.transpose();
    matrix.Add(nodes[i], k);
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
