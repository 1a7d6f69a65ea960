// Displacements of a mesh that is turned and bent far: the expensive model of elasticity.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/stiffness.h"
#include "acus/physics/mechanics/elements/supported_nodes.h"

namespace acus::mechanics {

struct CorotationalLimits {
  int max_iterations = 100;
  /// Largest force out of balance over the largest force on a node; never below round-off.
  double tolerance = 1e-9;
};

struct CorotationalSolution {
  Eigen::Matrix3Xd displacement_mm;  ///< 3 x n.
  int num_iterations = 0;
  double imbalance_n = 0.0;  ///< Largest force out of balance on a free node.
  int num_inverted = 0;      ///< Tetrahedra that are inside out; if any, forces beyond all use.
};

/// Linear elasticity in the frame of each tetrahedron (Mueller and Gross 2004), as the minimum of
/// an energy: large turns and small strains are right, large strains are only bounded. Of both
/// elements; by Newton's method with a line search, one factorisation per iteration. Not for the
/// step of a simulation. docs/models/tissue_elasticity.md
class CorotationalSolver {
 public:
  /// @throws as FindFreeNodes and AssembleStiffness.
  CorotationalSolver(const mesh::TetraMesh& mesh, const ElasticityTable& table, ElementKind kind,
                     const CorotationalLimits& limits = {});
  ~CorotationalSolver();
  CorotationalSolver(CorotationalSolver&&) noexcept;
  CorotationalSolver& operator=(CorotationalSolver&&) noexcept;

  /// @param force_n  3 x n, LPS; forces keep their direction. On held nodes they have no effect.
  /// @param held_mm  3 x n: where fixed nodes are moved to; empty: they stay.
  /// @param start_mm  3 x n: a solution nearby, such as the last image's; empty: at rest.
  /// @throws NoAnswerError if it does not converge.
  CorotationalSolution Solve(const Eigen::Matrix3Xd& force_n, const Eigen::Matrix3Xd& held_mm = {},
                             const Eigen::Matrix3Xd& start_mm = {});

  /// Forces that hold these displacements, 3 x n, N.
  Eigen::Matrix3Xd Forces(const Eigen::Matrix3Xd& displacement_mm) const;

  /// Energy stored in the tissue at these displacements, N mm.
  double EnergyNmm(const Eigen::Matrix3Xd& displacement_mm) const;

  const FreeNodes& free() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace acus::mechanics
