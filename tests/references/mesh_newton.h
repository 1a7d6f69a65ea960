// Newton's method for the energy of a mesh: what the non-linear static solvers share.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <optional>
#include <string>

#include "acus/physics/mechanics/elements/supported_nodes.h"
#include "acus/physics/mechanics/sparse/sparse_factor.h"

namespace acus::mechanics {

/// What to do where the second derivative of the energy is negative, as in compression: keep it, or
/// drop what is negative, tetrahedron by tetrahedron, so that steps go down.
enum class Curvature { kExact, kPositive };

/// Energy of a mesh and its derivatives at the displacements of the last MoveTo(). 3 x n, mm and N.
class MeshEnergy {
 public:
  virtual ~MeshEnergy() = default;
  virtual void MoveTo(const Eigen::Matrix3Xd& displacement_mm) = 0;
  virtual double EnergyNmm() const = 0;
  virtual Eigen::Matrix3Xd ForcesN() const = 0;
  /// Of all nodes, lower triangle; the same places for any displacement.
  virtual Eigen::SparseMatrix<double> Stiffness(Curvature curvature) const = 0;
  /// Forces below this cannot be told from none.
  virtual double NoiseN() const = 0;
};

struct NewtonLimits {
  int max_iterations = 100;
  /// Largest force out of balance over the largest force on a node; never below round-off.
  double tolerance = 1e-9;
};

struct NewtonSolution {
  Eigen::Matrix3Xd displacement_mm;  ///< 3 x n. The energy is left there.
  int num_iterations = 0;
  double imbalance_n = 0.0;  ///< Largest force out of balance on a free node.
};

/// Newton's method with a line search, one factorisation per iteration; keeps the symbolic factor.
class MeshNewton {
 public:
  /// @param name  Of the solution, for messages: "corotational".
  MeshNewton(FreeNodes free, const NewtonLimits& limits, std::string name);

  /// @param force_n, held_mm, start_mm  As CorotationalSolver::Solve.
  /// @throws NoAnswerError if it does not converge; never a value that is not finite.
  NewtonSolution Solve(MeshEnergy& energy, const Eigen::Matrix3Xd& force_n,
                       const Eigen::Matrix3Xd& held_mm, const Eigen::Matrix3Xd& start_mm);

  const FreeNodes& free() const { return free_; }

 private:
  Eigen::Matrix3Xd OnFree(Eigen::Matrix3Xd force_n) const;
  Eigen::SparseMatrix<double> FactoredStiffness(const MeshEnergy& energy);
  Eigen::Matrix3Xd Step(const MeshEnergy& energy, const Eigen::Matrix3Xd& wanted_n,
                        const Eigen::Matrix3Xd& held_step_mm);
  bool GoDown(MeshEnergy& energy, Eigen::Matrix3Xd& u, const Eigen::Matrix3Xd& load_n,
              const Eigen::Matrix3Xd& step, double slope) const;
  [[noreturn]] void Fail(const NewtonSolution& solution, double scale_n) const;

  FreeNodes free_;
  NewtonLimits limits_;
  std::string name_;
  std::optional<SparseFactor> factor_;
};

}  // namespace acus::mechanics
