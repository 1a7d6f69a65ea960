#include "acus/physics/mechanics/elements/stiffness.h"

#include <algorithm>
#include <vector>

#include "acus/physics/mechanics/elements/element_patches.h"
#include "acus/physics/mechanics/elements/linear_tetrahedron.h"
#include "acus/physics/mechanics/sparse/block_matrix.h"

namespace acus::mechanics {
namespace {

/// Adds the stiffness of one patch: each tetrahedron against change of shape, all together against
/// the mean change of volume, K V mean^2 / 2 with V mean = b u.
void AddPatch(const mesh::TetraMesh& mesh, const ElasticTissue& tissue, const ElementPatch& patch,
              BlockMatrix& matrix) {
  const std::vector<int>& nodes = patch.nodes;
  const auto size = static_cast<Eigen::Index>(3 * nodes.size());
  Eigen::VectorXd volume_gradient_mm2 = Eigen::VectorXd::Zero(size);
  double volume_mm3 = 0.0;
  for (const int t : patch.tetrahedra) {
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
  const std::vector<ElementPatch> patches = ElementPatches(mesh, kind, is_left_out);
  BlockMatrix matrix(static_cast<int>(mesh.nodes_mm.cols()), patches);
  for (const ElementPatch& patch : patches) {
    AddPatch(mesh, table.SolidAt(mesh.tissue[patch.tetrahedra[0]]), patch, matrix);
  }
  Eigen::SparseMatrix<double> out = std::move(matrix).Take();
  if (!table.membranes.empty()) out += MembraneStiffness(mesh, table.membranes, is_left_out);
  return out;
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
