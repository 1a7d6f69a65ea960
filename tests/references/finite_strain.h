// Displacements at large strain of tissue that stiffens: the most expensive model of elasticity.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/stiffness.h"
#include "acus/physics/mechanics/elements/supported_nodes.h"

namespace acus::mechanics {

struct FiniteStrainLimits {
  int max_iterations = 200;
  /// Largest force out of balance over the largest force on a node; never below round-off.
  double tolerance = 1e-9;
};

struct FiniteStrainSolution {
  Eigen::Matrix3Xd displacement_mm;  ///< 3 x n.
  int num_iterations = 0;
  double imbalance_n = 0.0;      ///< Largest force out of balance on a free node.
  int num_inverted = 0;          ///< Tetrahedra inside out; if any, forces beyond all use.
  double largest_stretch = 1.0;  ///< Of all tetrahedra.
};

/// Static equilibrium with the laws of the elasticity table (hyperelastic_law.h), of both elements:
/// kAveragedDilatation averages the volume ratio J over patches (an energy form of de Souza Neto et
/// al. 2005, Int. J. Numer. Meth. Engng 62(3):353-383). Newton's method with a line search. At
/// small strains it is the StaticSolver of the same table. Not for the step of a simulation: that
/// is tissue::StrainContact. docs/models/tissue_finite_strain.md
class FiniteStrainSolver {
 public:
  /// @throws as FindFreeNodes and AssembleStiffness.
  FiniteStrainSolver(const mesh::TetraMesh& mesh, const ElasticityTable& table, ElementKind kind,
                     const FiniteStrainLimits& limits = {});
  ~FiniteStrainSolver();
  FiniteStrainSolver(FiniteStrainSolver&&) noexcept;
  FiniteStrainSolver& operator=(FiniteStrainSolver&&) noexcept;

  /// @param force_n  3 x n, LPS; forces keep their direction. On held nodes they have no effect.
  /// @param held_mm  3 x n: where fixed nodes are moved to; empty: they stay.
  /// @param start_mm  3 x n: a solution nearby; empty: at rest.
  /// @throws NoAnswerError if it does not converge; never a value that is not finite.
  FiniteStrainSolution Solve(const Eigen::Matrix3Xd& force_n, const Eigen::Matrix3Xd& held_mm = {},
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
