#include "references/finite_strain.h"

#include <Eigen/SVD>
#include <algorithm>
#include <utility>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/elements/finite_strain_body.h"
#include "acus/physics/mechanics/sparse/block_matrix.h"
#include "references/mesh_newton.h"

namespace acus::mechanics {
namespace {

constexpr double kStrainRoundOff = 2e-12;  // Of the force by a strain of 1: forces below are noise.

using Corners34 = Eigen::Matrix<double, 3, 4>;

double MeanVolumeRatio(const FiniteStrainBody& body, const FiniteStrainPatch& patch,
                       std::span<const StrainedTetrahedron> state) noexcept {
  double sum_mm3 = 0.0;
  for (int t = patch.first; t < patch.first + patch.count; ++t) {
    sum_mm3 += body.shapes[t].volume_mm3 * state[t].volume_ratio;
  }
  return sum_mm3 / patch.volume_mm3;
}

/// Rows of shape function gradients that turn entries of F (column by column) into corner values.
Eigen::Matrix<double, 9, 12> GradientByCorners(const LinearTetrahedron& shape) {
  Eigen::Matrix<double, 9, 12> b = Eigen::Matrix<double, 9, 12>::Zero();
  for (int c = 0; c < 4; ++c) {
    for (int k = 0; k < 3; ++k) {
      b.block<3, 3>(3 * k, 3 * c).diagonal().setConstant(shape.gradients_per_mm(k, c));
    }
  }
  return b;
}

double EnergyNmm(const FiniteStrainBody& body,
                 std::span<const StrainedTetrahedron> state) noexcept {
  double energy = 0.0;
  for (const FiniteStrainPatch& patch : body.patches) {
    const double mean = MeanVolumeRatio(body, patch, state);
    energy += 0.5 * patch.volume_mm3 * patch.bulk_mpa * (mean - 1.0) * (mean - 1.0);
    for (int t = patch.first; t < patch.first + patch.count; ++t) {
      const double off2 = (state[t].volume_ratio - mean) * (state[t].volume_ratio - mean);
      energy += body.shapes[t].volume_mm3 *
                (ShapeEnergyMpa(patch.law, patch.shear_mpa, state[t].gradient) +
                 kOwnVolume * patch.shear_mpa * off2 * off2);
    }
  }
  return energy;
}

/// Adds the forces that hold the nodes, N.
void AddForces(const FiniteStrainBody& body, std::span<const StrainedTetrahedron> state,
               Eigen::Ref<Eigen::Matrix3Xd> force_n) noexcept {
  for (const FiniteStrainPatch& patch : body.patches) {
    for (int t = patch.first; t < patch.first + patch.count; ++t) {
      const LinearTetrahedron& shape = body.shapes[t];
      Eigen::Matrix3d stress = ShapeStressMpa(patch.law, patch.shear_mpa, state[t].gradient);
      stress += state[t].pressure_mpa * Cofactor(state[t].gradient);
      const Corners34 f = shape.volume_mm3 * stress * shape.gradients_per_mm;
      for (int c = 0; c < 4; ++c) force_n.col(body.corners[t][c]) += f.col(c);
    }
  }
}

/// Stiffness of one patch, N/mm, by 3 times the place in `nodes` (ascending) + axis.
Eigen::MatrixXd PatchStiffness(const FiniteStrainBody& body, int patch_number,
                               std::span<const int> nodes,
                               std::span<const StrainedTetrahedron> state, Curvature curvature) {
  const FiniteStrainPatch& patch = body.patches[static_cast<std::size_t>(patch_number)];
  const double mean = MeanVolumeRatio(body, patch, state);
  const auto size = static_cast<Eigen::Index>(3 * nodes.size());
  Eigen::MatrixXd k = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd mean_by_u = Eigen::VectorXd::Zero(size);  // d Jbar / du.
  Eigen::VectorXd weighted = Eigen::VectorXd::Zero(size);   // sum V h dJ_t / du.
  double weight_sum = 0.0;
  for (int t = patch.first; t < patch.first + patch.count; ++t) {
    const LinearTetrahedron& shape = body.shapes[t];
    std::array<Eigen::Index, 4> at{};
    for (int c = 0; c < 4; ++c) {
      at[c] = 3 * (std::ranges::lower_bound(nodes, body.corners[t][c]) - nodes.begin());
    }
    Matrix9 tangent =
        ShapeTangentMpa(patch.law, patch.shear_mpa, state[t].gradient, state[t].pressure_mpa);
    if (curvature == Curvature::kPositive) tangent = PositivePart(tangent);
    const double off = state[t].volume_ratio - mean;
    const double h = 12.0 * kOwnVolume * patch.shear_mpa * off * off * shape.volume_mm3;
    const Corners34 j_by_u = Cofactor(state[t].gradient) * shape.gradients_per_mm;
    const Eigen::Map<const Eigen::Matrix<double, 12, 1>> j(j_by_u.data());
    const Eigen::Matrix<double, 9, 12> b = GradientByCorners(shape);
    TetrahedronMatrix own = shape.volume_mm3 * (b.transpose() * tangent * b);
    own += h * j * j.transpose();
    for (int c = 0; c < 4; ++c) {
      mean_by_u.segment<3>(at[c]) += shape.volume_mm3 / patch.volume_mm3 * j.segment<3>(3 * c);
      weighted.segment<3>(at[c]) += h * j.segment<3>(3 * c);
      for (int d = 0; d < 4; ++d) {
        k.block<3, 3>(at[c], at[d]) += own.block<3, 3>(3 * c, 3 * d);
      }
    }
    weight_sum += h;
  }
  k += (patch.bulk_mpa * patch.volume_mm3 + weight_sum) * mean_by_u * mean_by_u.transpose();
  k -= weighted * mean_by_u.transpose() + mean_by_u * weighted.transpose();
  return k;
}

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
    AddForces(body, state, force_n);
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
