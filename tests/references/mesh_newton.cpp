#include "references/mesh_newton.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/elements/stiffness.h"

namespace acus::mechanics {
namespace {

constexpr double kArmijo = 1e-4;     // Share of the promised fall of energy that a step must bring.
constexpr int kMaxHalvings = 30;     // Of one step.
constexpr double kRoundOff = 1e-14;  // Of an energy; a fall below it cannot be seen.

double WorkOf(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  return a.cwiseProduct(b).sum();
}

}  // namespace

MeshNewton::MeshNewton(FreeNodes free, const NewtonLimits& limits, std::string name)
    : free_(std::move(free)), limits_(limits), name_(std::move(name)) {}

/// The part of forces that free nodes feel.
Eigen::Matrix3Xd MeshNewton::OnFree(Eigen::Matrix3Xd force_n) const {
  for (Eigen::Index i = 0; i < force_n.cols(); ++i) {
    if (free_.row_of_node[static_cast<std::size_t>(i)] < 0) force_n.col(i).setZero();
  }
  return force_n;
}

/// Factors the exact stiffness if that is positive definite, as near every stable solution, and
/// otherwise the part of it that always is.
Eigen::SparseMatrix<double> MeshNewton::FactoredStiffness(const MeshEnergy& energy) {
  Eigen::SparseMatrix<double> all = energy.Stiffness(Curvature::kExact);
  const Eigen::SparseMatrix<double> of_free = FreeStiffness(all, free_);
  if (factor_ && factor_->TryRefactor(of_free)) return all;
  all = energy.Stiffness(Curvature::kPositive);
  const Eigen::SparseMatrix<double> positive = FreeStiffness(all, free_);
  if (factor_) {
    factor_->Refactor(positive);
  } else {
    factor_.emplace(positive);
  }
  return all;
}

/// Newton's step from a state: held nodes go by `held_step_mm`, the others to where the forces on
/// them, to first order, are `wanted_n` more.
Eigen::Matrix3Xd MeshNewton::Step(const MeshEnergy& energy, const Eigen::Matrix3Xd& wanted_n,
                                  const Eigen::Matrix3Xd& held_step_mm) {
  const Eigen::SparseMatrix<double> all = FactoredStiffness(energy);
  Eigen::Matrix3Xd step = held_step_mm;
  Eigen::Matrix3Xd right = wanted_n;
  Eigen::Map<Eigen::VectorXd>(right.data(), right.size()) -=
      all.selfadjointView<Eigen::Lower>() *
      Eigen::Map<const Eigen::VectorXd>(step.data(), step.size());
  Eigen::VectorXd packed(free_.num_dofs());
  for (std::size_t r = 0; r < free_.mesh_node.size(); ++r) {
    packed.segment<3>(static_cast<Eigen::Index>(3 * r)) = right.col(free_.mesh_node[r]);
  }
  packed = factor_->Solve(packed);
  for (std::size_t r = 0; r < free_.mesh_node.size(); ++r) {
    step.col(free_.mesh_node[r]) = packed.segment<3>(static_cast<Eigen::Index>(3 * r));
  }
  return step;
}

/// Shortens the step until the energy falls enough. False if it cannot be seen to fall.
bool MeshNewton::GoDown(MeshEnergy& energy, Eigen::Matrix3Xd& u, const Eigen::Matrix3Xd& load_n,
                        const Eigen::Matrix3Xd& step, double slope) const {
  const double before = energy.EnergyNmm() - WorkOf(load_n, u);
  const double noise = kRoundOff * (std::abs(before) + std::abs(WorkOf(load_n, u))) +
                       energy.NoiseN() * (u + step).colwise().norm().maxCoeff();
  double length = 1.0;
  for (int halving = 0; halving < kMaxHalvings; ++halving, length *= 0.5) {
    const Eigen::Matrix3Xd there = u + length * step;
    energy.MoveTo(there);
    const double after = energy.EnergyNmm() - WorkOf(load_n, there);
    if (!(after <= before + kArmijo * length * slope + noise)) continue;
    u = there;
    return true;
  }
  return false;
}

NewtonSolution MeshNewton::Solve(MeshEnergy& energy, const Eigen::Matrix3Xd& force_n,
                                 const Eigen::Matrix3Xd& held_mm,
                                 const Eigen::Matrix3Xd& start_mm) {
  const Eigen::Matrix3Xd load_n = OnFree(force_n);
  const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, force_n.cols());
  Eigen::Matrix3Xd u = start_mm.size() > 0 ? start_mm : none;
  energy.MoveTo(u);
  Eigen::Matrix3Xd held_step = (held_mm.size() > 0 ? held_mm : none) - u;
  held_step -= OnFree(held_step);
  NewtonSolution solution;
  if (!(load_n.allFinite() && u.allFinite() && held_step.allFinite())) Fail(solution, 0.0);
  if (!held_step.isZero(0.0)) {
    // Held nodes go where they must, and take the others along: no energy to compare with yet.
    u += Step(energy, OnFree(load_n - energy.ForcesN()), held_step);
    energy.MoveTo(u);
  }
  for (;; ++solution.num_iterations) {
    const Eigen::Matrix3Xd inner_n = energy.ForcesN();
    const Eigen::Matrix3Xd out_of_balance_n = OnFree(load_n - inner_n);
    solution.imbalance_n = out_of_balance_n.colwise().norm().maxCoeff();
    const double scale_n =
        std::max(load_n.colwise().norm().maxCoeff(), inner_n.colwise().norm().maxCoeff());
    if (!std::isfinite(solution.imbalance_n) || !inner_n.allFinite()) Fail(solution, scale_n);
    if (solution.imbalance_n <= std::max(limits_.tolerance * scale_n, energy.NoiseN())) break;
    if (solution.num_iterations >= limits_.max_iterations) Fail(solution, scale_n);
    const Eigen::Matrix3Xd step = Step(energy, out_of_balance_n, none);
    if (!GoDown(energy, u, load_n, step, -WorkOf(out_of_balance_n, step))) Fail(solution, scale_n);
  }
  solution.displacement_mm = std::move(u);
  return solution;
}

void MeshNewton::Fail(const NewtonSolution& solution, double scale_n) const {
  throw NoAnswerError(Message(
      "the ", name_, " solution did not converge: after ", solution.num_iterations, " iterations ",
      solution.imbalance_n, " N of ", scale_n,
      " N are out of balance; the load may be more than the tissue holds, or make it buckle: ",
      "approach it in smaller steps, each from the solution before"));
}

}  // namespace acus::mechanics
