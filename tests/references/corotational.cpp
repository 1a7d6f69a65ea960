#include "references/corotational.h"

#include <algorithm>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/physics/mechanics/elements/element_patches.h"
#include "acus/physics/mechanics/sparse/block_matrix.h"
#include "references/corotational_element.h"
#include "references/mesh_newton.h"

namespace acus::mechanics {
namespace {

constexpr double kForceRoundOff = 1e-13;  // Of the force by a strain of 1: forces below are noise.

}  // namespace

struct CorotationalSolver::Impl : MeshEnergy {
  struct State {
    std::vector<RotatedTetrahedron> elements;  ///< By tetrahedron of the mesh.
    std::vector<double> mean_stress_mpa;       ///< By patch.
    std::vector<double> mean_dilatation;       ///< By patch.
  };

  mesh::TetraMesh mesh;
  MeshNewton newton;
  std::vector<ElementPatch> patches;
  std::vector<ElasticTissue> tissue;      ///< Of each patch.
  std::vector<double> volume_mm3;         ///< Of each patch.
  std::vector<LinearTetrahedron> shapes;  ///< By tetrahedron of the mesh.
  double noise_n = 0.0;                   ///< Forces below this cannot be told from none.
  BlockMatrix zero;                       ///< The stiffness' places.
  State now;                              ///< At the last MoveTo().

  Impl(const mesh::TetraMesh& the_mesh, const ElasticityTable& table, ElementKind kind,
       const CorotationalLimits& the_limits)
      : mesh(the_mesh),
        newton(FindFreeNodes(mesh), {the_limits.max_iterations, the_limits.tolerance},
               "corotational"),
        patches(ElementPatches(mesh, kind, newton.free().is_left_out)),
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

  void MoveTo(const Eigen::Matrix3Xd& u) override { now = StateAt(u); }
  double EnergyNmm() const override { return EnergyNmm(now); }
  Eigen::Matrix3Xd ForcesN() const override { return Forces(now); }
  Eigen::SparseMatrix<double> Stiffness(Curvature curvature) const override {
    return Stiffness(now, curvature);
  }
  double NoiseN() const override { return noise_n; }

  CorotationalSolution Solve(const Eigen::Matrix3Xd& force_n, const Eigen::Matrix3Xd& held_mm,
                             const Eigen::Matrix3Xd& start_mm) {
    NewtonSolution found = newton.Solve(*this, force_n, held_mm, start_mm);
    CorotationalSolution solution;
    solution.num_iterations = found.num_iterations;
    solution.imbalance_n = found.imbalance_n;
    solution.num_inverted = static_cast<int>(std::ranges::count_if(
        now.elements, [](const RotatedTetrahedron& e) { return e.stretches[2] < 0.0; }));
    solution.displacement_mm = std::move(found.displacement_mm);
    return solution;
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
  return impl_->newton.free();
}

}  // namespace acus::mechanics
