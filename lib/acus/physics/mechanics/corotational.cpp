#include "acus/physics/mechanics/corotational.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/block_matrix.h"
#include "acus/physics/mechanics/corotational_element.h"
#include "acus/physics/mechanics/element_patches.h"
#include "acus/physics/mechanics/sparse_factor.h"

namespace acus::mechanics {
namespace {

constexpr double kArmijo = 1e-4;     // Share of the promised fall of energy that a step must bring.
constexpr int kMaxHalvings = 30;     // Of one step.
constexpr double kRoundOff = 1e-14;  // Of an energy; a fall below it cannot be seen.
constexpr double kForceRoundOff = 1e-13;  // Of the force by a strain of 1: forces below are noise.

double Dot(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  return a.cwiseProduct(b).sum();
}

}  // namespace

struct CorotationalSolver::Impl {
  struct State {
    std::vector<RotatedTetrahedron> elements;  ///< By tetrahedron of the mesh.
    std::vector<double> mean_stress_mpa;       ///< By patch.
    std::vector<double> mean_dilatation;       ///< By patch.
  };

  mesh::TetraMesh mesh;
  FreeNodes free;
  CorotationalLimits limits;
  std::vector<ElementPatch> patches;
  std::vector<ElasticTissue> tissue;      ///< Of each patch.
  std::vector<double> volume_mm3;         ///< Of each patch.
  std::vector<LinearTetrahedron> shapes;  ///< By tetrahedron of the mesh.
  double noise_n = 0.0;                   ///< Forces below this cannot be told from none.
  BlockMatrix zero;                       ///< The stiffness' places.
  std::optional<SparseFactor> factor;

  Impl(const mesh::TetraMesh& the_mesh, const ElasticityTable& table, ElementKind kind,
       const CorotationalLimits& the_limits)
      : mesh(the_mesh),
        free(FindFreeNodes(mesh)),
        limits(the_limits),
        patches(ElementPatches(mesh, kind, free.is_left_out)),
        shapes(mesh.tissue.size()),
        zero(static_cast<int>(mesh.nodes_mm.cols()), patches) {
    for (const ElementPatch& patch : patches) {
      tissue.push_back(table.At(mesh.tissue[patch.tetrahedra[0]]));
      double& volume = volume_mm3.emplace_back(0.0);
      for (const int t : patch.tetrahedra) {
        shapes[t] = LinearTetrahedronOf(mesh, t);
        volume += shapes[t].volume_mm3;
        const double unit_n = (tissue.back().BulkModulusMpa() + tissue.back().ShearModulusMpa()) *
                              shapes[t].volume_mm3 *
                              shapes[t].gradients_per_mm.colwise().norm().maxCoeff();
        noise_n = std::max(noise_n, kForceRoundOff * unit_n);
      }
    }
  }

  State StateAt(const Eigen::Matrix3Xd& u) const {
    State state;
    state.elements.resize(shapes.size());
    for (std::size_t p = 0; p < patches.size(); ++p) {
      double change_mm3 = 0.0;
      for (const int t : patches[p].tetrahedra) {
        CornerVectors corners;
        for (int c = 0; c < 4; ++c) corners.col(c) = u.col(mesh.tetrahedra(c, t));
        state.elements[t] = Rotated(shapes[t], corners);
        change_mm3 += shapes[t].volume_mm3 * state.elements[t].Dilatation();
      }
      state.mean_dilatation.push_back(change_mm3 / volume_mm3[p]);
      state.mean_stress_mpa.push_back(tissue[p].BulkModulusMpa() * state.mean_dilatation.back());
    }
    return state;
  }

  double EnergyNmm(const State& state) const {
    double energy = 0.0;
    for (std::size_t p = 0; p < patches.size(); ++p) {
      energy += 0.5 * volume_mm3[p] * state.mean_stress_mpa[p] * state.mean_dilatation[p];
      for (const int t : patches[p].tetrahedra) {
        energy += ShapeEnergyNmm(shapes[t], state.elements[t], tissue[p].ShearModulusMpa());
      }
    }
    return energy;
  }

  Eigen::Matrix3Xd Forces(const State& state) const {
    Eigen::Matrix3Xd force_n = Eigen::Matrix3Xd::Zero(3, mesh.nodes_mm.cols());
    for (std::size_t p = 0; p < patches.size(); ++p) {
      for (const int t : patches[p].tetrahedra) {
        const CornerVectors f = CornerForcesN(
            shapes[t], state.elements[t], tissue[p].ShearModulusMpa(), state.mean_stress_mpa[p]);
        for (int c = 0; c < 4; ++c) force_n.col(mesh.tetrahedra(c, t)) += f.col(c);
      }
    }
    return force_n;
  }

  /// Of all nodes, lower triangle.
  Eigen::SparseMatrix<double> Stiffness(const State& state, Curvature curvature) const {
    BlockMatrix matrix = zero;
    for (std::size_t p = 0; p < patches.size(); ++p) {
      const std::vector<int>& nodes = patches[p].nodes;
      Eigen::VectorXd gradient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * nodes.size()));
      for (const int t : patches[p].tetrahedra) {
        const Eigen::Vector4i corners = mesh.tetrahedra.col(t);
        matrix.Add({corners.data(), 4},
                   CornerStiffness(shapes[t], state.elements[t], tissue[p].ShearModulusMpa(),
                                   state.mean_stress_mpa[p], curvature));
        const CornerVectors b = RotatedVolumeGradientMm2(shapes[t], state.elements[t]);
        for (int c = 0; c < 4; ++c) {
          const auto at = std::ranges::lower_bound(nodes, corners[c]) - nodes.begin();
          gradient.segment<3>(3 * at) += b.col(c);
        }
      }
      matrix.Add(nodes,
                 tissue[p].BulkModulusMpa() / volume_mm3[p] * gradient * gradient.transpose());
    }
    return std::move(matrix).Take();
  }

  /// The part of forces that free nodes feel.
  Eigen::Matrix3Xd OnFree(Eigen::Matrix3Xd force_n) const {
    for (Eigen::Index i = 0; i < force_n.cols(); ++i) {
      if (free.row_of_node[static_cast<std::size_t>(i)] < 0) force_n.col(i).setZero();
    }
    return force_n;
  }

  /// Factors the exact stiffness if that is positive definite, as near every stable solution, and
  /// otherwise the part of it that always is.
  Eigen::SparseMatrix<double> FactoredStiffness(const State& state) {
    Eigen::SparseMatrix<double> all = Stiffness(state, Curvature::kExact);
    const Eigen::SparseMatrix<double> of_free = FreeStiffness(all, free);
    if (factor && factor->TryRefactor(of_free)) return all;
    all = Stiffness(state, Curvature::kPositive);
    const Eigen::SparseMatrix<double> positive = FreeStiffness(all, free);
    if (factor) {
      factor->Refactor(positive);
    } else {
      factor.emplace(positive);
    }
    return all;
  }

  /// Newton's step from a state: held nodes go by `held_step_mm`, the others to where the forces on
  /// them, to first order, are `wanted_n` more.
  Eigen::Matrix3Xd Step(const State& state, const Eigen::Matrix3Xd& wanted_n,
                        const Eigen::Matrix3Xd& held_step_mm) {
    const Eigen::SparseMatrix<double> all = FactoredStiffness(state);
    Eigen::Matrix3Xd step = held_step_mm;
    Eigen::Matrix3Xd right = wanted_n;
    Eigen::Map<Eigen::VectorXd>(right.data(), right.size()) -=
        all.selfadjointView<Eigen::Lower>() *
        Eigen::Map<const Eigen::VectorXd>(step.data(), step.size());
    Eigen::VectorXd packed(free.num_dofs());
    for (std::size_t r = 0; r < free.mesh_node.size(); ++r) {
      packed.segment<3>(static_cast<Eigen::Index>(3 * r)) = right.col(free.mesh_node[r]);
    }
    packed = factor->Solve(packed);
    for (std::size_t r = 0; r < free.mesh_node.size(); ++r) {
      step.col(free.mesh_node[r]) = packed.segment<3>(static_cast<Eigen::Index>(3 * r));
    }
    return step;
  }

  /// Shortens the step until the energy falls enough. False if it cannot be seen to fall.
  bool GoDown(Eigen::Matrix3Xd& u, State& state, const Eigen::Matrix3Xd& load_n,
              const Eigen::Matrix3Xd& step, double slope) const {
    const double before = EnergyNmm(state) - Dot(load_n, u);
    const double noise = kRoundOff * (std::abs(before) + std::abs(Dot(load_n, u))) +
                         noise_n * (u + step).colwise().norm().maxCoeff();
    double length = 1.0;
    for (int halving = 0; halving < kMaxHalvings; ++halving, length *= 0.5) {
      const Eigen::Matrix3Xd there = u + length * step;
      State state_there = StateAt(there);
      const double after = EnergyNmm(state_there) - Dot(load_n, there);
      if (!(after <= before + kArmijo * length * slope + noise)) continue;
      u = there;
      state = std::move(state_there);
      return true;
    }
    return false;
  }

  CorotationalSolution Solve(const Eigen::Matrix3Xd& force_n, const Eigen::Matrix3Xd& held_mm,
                             const Eigen::Matrix3Xd& start_mm) {
    const Eigen::Matrix3Xd load_n = OnFree(force_n);
    const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, mesh.nodes_mm.cols());
    Eigen::Matrix3Xd u = start_mm.size() > 0 ? start_mm : none;
    State state = StateAt(u);
    Eigen::Matrix3Xd held_step = (held_mm.size() > 0 ? held_mm : none) - u;
    held_step -= OnFree(held_step);
    if (!held_step.isZero(0.0)) {
      // Held nodes go where they must, and take the others along: no energy to compare with yet.
      u += Step(state, OnFree(load_n - Forces(state)), held_step);
      state = StateAt(u);
    }
    CorotationalSolution solution;
    for (;; ++solution.num_iterations) {
      const Eigen::Matrix3Xd inner_n = Forces(state);
      const Eigen::Matrix3Xd out_of_balance_n = OnFree(load_n - inner_n);
      solution.imbalance_n = out_of_balance_n.colwise().norm().maxCoeff();
      const double scale_n =
          std::max(load_n.colwise().norm().maxCoeff(), inner_n.colwise().norm().maxCoeff());
      if (solution.imbalance_n <= std::max(limits.tolerance * scale_n, noise_n)) break;
      if (solution.num_iterations >= limits.max_iterations) Fail(solution, scale_n);
      const Eigen::Matrix3Xd step = Step(state, out_of_balance_n, none);
      if (!GoDown(u, state, load_n, step, -Dot(out_of_balance_n, step))) Fail(solution, scale_n);
    }
    solution.num_inverted = static_cast<int>(std::ranges::count_if(
        state.elements, [](const RotatedTetrahedron& e) { return e.stretches[2] < 0.0; }));
    solution.displacement_mm = std::move(u);
    return solution;
  }

  [[noreturn]] void Fail(const CorotationalSolution& solution, double scale_n) const {
    throw NoAnswerError(Message(
        "the corotational solution did not converge: after ", solution.num_iterations,
        " iterations ", solution.imbalance_n, " N of ", scale_n,
        " N are out of balance; the load may be more than the tissue holds, or make it buckle: ",
        "approach it in smaller steps, each from the solution before"));
  }
};

CorotationalSolver::CorotationalSolver(const mesh::TetraMesh& mesh, const ElasticityTable& table,
                                       ElementKind kind, const CorotationalLimits& limits)
    : impl_(std::make_unique<Impl>(mesh, table, kind, limits)) {}
CorotationalSolver::~CorotationalSolver() = default;
CorotationalSolver::CorotationalSolver(CorotationalSolver&&) noexcept = default;
CorotationalSolver& CorotationalSolver::operator=(CorotationalSolver&&) noexcept = default;

CorotationalSolution CorotationalSolver::Solve(const Eigen::Matrix3Xd& force_n,
                                               const Eigen::Matrix3Xd& held_mm,
                                               const Eigen::Matrix3Xd& start_mm) {
  const Eigen::Index num_nodes = impl_->mesh.nodes_mm.cols();
  ACUS_ASSERT(force_n.cols() == num_nodes && (held_mm.size() == 0 || held_mm.cols() == num_nodes) &&
              (start_mm.size() == 0 || start_mm.cols() == num_nodes));
  return impl_->Solve(force_n, held_mm, start_mm);
}

Eigen::Matrix3Xd CorotationalSolver::Forces(const Eigen::Matrix3Xd& displacement_mm) const {
  return impl_->Forces(impl_->StateAt(displacement_mm));
}

double CorotationalSolver::EnergyNmm(const Eigen::Matrix3Xd& displacement_mm) const {
  return impl_->EnergyNmm(impl_->StateAt(displacement_mm));
}

const FreeNodes& CorotationalSolver::free() const {
  return impl_->free;
}

}  // namespace acus::mechanics
