#include "acus/physics/mechanics/finite_strain.h"

#include <Eigen/SVD>
#include <algorithm>
#include <utility>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/block_matrix.h"
#include "acus/physics/mechanics/finite_strain_body.h"

namespace acus::mechanics {
namespace {

constexpr double kStrainRoundOff = 2e-12;  // Of the force by a strain of 1: forces below are noise.

}  // namespace

struct FiniteStrainSolver::Impl : MeshEnergy {
  mesh::TetraMesh mesh;
  MeshNewton newton;
  std::vector<ElementPatch> patches;
  FiniteStrainBody body;
  double noise_n = 0.0;
  BlockMatrix zero;  ///< The stiffness' places.
  std::vector<StrainedTetrahedron> now;

  Impl(const mesh::TetraMesh& the_mesh, const ElasticityTable& table, ElementKind kind,
       const FiniteStrainLimits& limits)
      : mesh(the_mesh),
        newton(FindFreeNodes(mesh), {limits.max_iterations, limits.tolerance}, "finite strain"),
        patches(ElementPatches(mesh, kind, newton.free().is_left_out)),
        zero(static_cast<int>(mesh.nodes_mm.cols()), patches) {
    for (const ElementPatch& patch : patches) {
      body.Add(mesh, table, patch, {});
      const FiniteStrainPatch& made = body.patches.back();
      for (int t = made.first; t < made.first + made.count; ++t) {
        const double unit_n = (made.bulk_mpa + made.shear_mpa) * body.shapes[t].volume_mm3 *
                              body.shapes[t].gradients_per_mm.colwise().norm().maxCoeff();
        noise_n = std::max(noise_n, kStrainRoundOff * unit_n);
      }
    }
    now.resize(body.shapes.size());
  }

  std::vector<StrainedTetrahedron> At(const Eigen::Matrix3Xd& u) const {
    std::vector<StrainedTetrahedron> state(body.shapes.size());
    DeformAll(body, u, state);
    return state;
  }
  Eigen::Matrix3Xd Forces(const std::vector<StrainedTetrahedron>& state) const {
    Eigen::Matrix3Xd force_n = Eigen::Matrix3Xd::Zero(3, mesh.nodes_mm.cols());
    AddForces(body, state, 1.0, force_n);
    return force_n;
  }

  void MoveTo(const Eigen::Matrix3Xd& u) override { DeformAll(body, u, now); }
  double EnergyNmm() const override { return mechanics::EnergyNmm(body, now); }
  Eigen::Matrix3Xd ForcesN() const override { return Forces(now); }
  double NoiseN() const override { return noise_n; }
  Eigen::SparseMatrix<double> Stiffness(Curvature curvature) const override {
    BlockMatrix matrix = zero;
    for (std::size_t p = 0; p < patches.size(); ++p) {
      matrix.Add(patches[p].nodes,
                 PatchStiffness(body, static_cast<int>(p), patches[p].nodes, now, curvature));
    }
    return std::move(matrix).Take();
  }

  FiniteStrainSolution Solve(const Eigen::Matrix3Xd& force_n, const Eigen::Matrix3Xd& held_mm,
                             const Eigen::Matrix3Xd& start_mm) {
    NewtonSolution found = newton.Solve(*this, force_n, held_mm, start_mm);
    FiniteStrainSolution solution;
    solution.displacement_mm = std::move(found.displacement_mm);
    solution.num_iterations = found.num_iterations;
    solution.imbalance_n = found.imbalance_n;
    for (const StrainedTetrahedron& t : now) {
      if (t.volume_ratio < 0.0) ++solution.num_inverted;
      const double stretch = Eigen::JacobiSVD<Eigen::Matrix3d>(t.gradient).singularValues()[0];
      solution.largest_stretch = std::max(solution.largest_stretch, stretch);
    }
    return solution;
  }
};

FiniteStrainSolver::FiniteStrainSolver(const mesh::TetraMesh& mesh, const ElasticityTable& table,
                                       ElementKind kind, const FiniteStrainLimits& limits)
    : impl_(std::make_unique<Impl>(mesh, table, kind, limits)) {}
FiniteStrainSolver::~FiniteStrainSolver() = default;
FiniteStrainSolver::FiniteStrainSolver(FiniteStrainSolver&&) noexcept = default;
FiniteStrainSolver& FiniteStrainSolver::operator=(FiniteStrainSolver&&) noexcept = default;

FiniteStrainSolution FiniteStrainSolver::Solve(const Eigen::Matrix3Xd& force_n,
                                               const Eigen::Matrix3Xd& held_mm,
                                               const Eigen::Matrix3Xd& start_mm) {
  const Eigen::Index num_nodes = impl_->mesh.nodes_mm.cols();
  ACUS_ASSERT(force_n.cols() == num_nodes && (held_mm.size() == 0 || held_mm.cols() == num_nodes) &&
              (start_mm.size() == 0 || start_mm.cols() == num_nodes));
  return impl_->Solve(force_n, held_mm, start_mm);
}

Eigen::Matrix3Xd FiniteStrainSolver::Forces(const Eigen::Matrix3Xd& displacement_mm) const {
  return impl_->Forces(impl_->At(displacement_mm));
}

double FiniteStrainSolver::EnergyNmm(const Eigen::Matrix3Xd& displacement_mm) const {
  return mechanics::EnergyNmm(impl_->body, impl_->At(displacement_mm));
}

const FreeNodes& FiniteStrainSolver::free() const {
  return impl_->newton.free();
}

}  // namespace acus::mechanics
