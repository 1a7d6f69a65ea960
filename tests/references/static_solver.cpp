#include "references/static_solver.h"

#include "acus/base/core/error.h"

namespace acus::mechanics {

StaticSolver::StaticSolver(const mesh::TetraMesh& mesh, const ElasticityTable& table,
                           ElementKind kind)
    : free_(FindFreeNodes(mesh)),
      stiffness_n_per_mm_(AssembleStiffness(mesh, table, kind, free_.is_left_out)),
      factor_(FreeStiffness(stiffness_n_per_mm_, free_)) {}

Eigen::Matrix3Xd StaticSolver::Displacements(const Eigen::Matrix3Xd& force_n,
                                             const Eigen::Matrix3Xd& held_mm) const {
  const auto num_nodes = static_cast<Eigen::Index>(free_.row_of_node.size());
  ACUS_ASSERT(force_n.cols() == num_nodes && (held_mm.size() == 0 || held_mm.cols() == num_nodes));
  Eigen::Matrix3Xd displacement_mm = Eigen::Matrix3Xd::Zero(3, num_nodes);
  Eigen::Matrix3Xd load_n = force_n;
  if (held_mm.size() > 0) {
    for (Eigen::Index i = 0; i < num_nodes; ++i) {
      if (free_.row_of_node[i] < 0) displacement_mm.col(i) = held_mm.col(i);
    }
    load_n -= Forces(displacement_mm);
  }
  Eigen::VectorXd right(free_.num_dofs());
  for (std::size_t r = 0; r < free_.mesh_node.size(); ++r) {
    right.segment<3>(static_cast<Eigen::Index>(3 * r)) = load_n.col(free_.mesh_node[r]);
  }
  const Eigen::VectorXd solution = factor_.Solve(right);
  for (std::size_t r = 0; r < free_.mesh_node.size(); ++r) {
    displacement_mm.col(free_.mesh_node[r]) = solution.segment<3>(static_cast<Eigen::Index>(3 * r));
  }
  return displacement_mm;
}

Eigen::Matrix3Xd StaticSolver::Forces(const Eigen::Matrix3Xd& displacement_mm) const {
  ACUS_ASSERT(displacement_mm.size() == stiffness_n_per_mm_.rows());
  Eigen::Matrix3Xd force_n(3, displacement_mm.cols());
  Eigen::Map<Eigen::VectorXd>(force_n.data(), force_n.size()) =
      stiffness_n_per_mm_.selfadjointView<Eigen::Lower>() *
      Eigen::Map<const Eigen::VectorXd>(displacement_mm.data(), displacement_mm.size());
  return force_n;
}

}  // namespace acus::mechanics
