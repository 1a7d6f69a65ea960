#include "acus/physics/mechanics/elements/finite_strain_body.h"

namespace acus::mechanics {
namespace {

using Corners34 = Eigen::Matrix<double, 3, 4>;

/// Sets the pressures of a patch: K (Jbar - 1), and of what keeps J_t near Jbar.
void BalanceVolume(const FiniteStrainBody& body, const FiniteStrainPatch& patch,
                   std::span<StrainedTetrahedron> state) noexcept {
  double sum_mm3 = 0.0;
  for (int t = patch.first; t < patch.first + patch.count; ++t) {
    sum_mm3 += body.shapes[t].volume_mm3 * state[t].volume_ratio;
  }
  const double mean = sum_mm3 / patch.volume_mm3;
  double own_sum = 0.0;
  for (int t = patch.first; t < patch.first + patch.count; ++t) {
    const double off = state[t].volume_ratio - mean;
    state[t].pressure_mpa = 4.0 * kOwnVolume * patch.shear_mpa * off * off * off;
    own_sum += body.shapes[t].volume_mm3 * state[t].pressure_mpa;
  }
  const double common = patch.bulk_mpa * (mean - 1.0) - own_sum / patch.volume_mm3;
  for (int t = patch.first; t < patch.first + patch.count; ++t) state[t].pressure_mpa += common;
}

void Scatter(const std::array<int, 4>& corners, const Corners34& force_n,
             Eigen::Ref<Eigen::Matrix3Xd>& out) noexcept {
  for (int c = 0; c < 4; ++c) out.col(corners[c]) += force_n.col(c);
}

}  // namespace

void FiniteStrainBody::Add(const mesh::TetraMesh& mesh, const ElasticityTable& table,
                           const ElementPatch& patch, std::span<const int> node_of_mesh_node) {
  const volume::Label label = mesh.tissue[static_cast<std::size_t>(patch.tetrahedra[0])];
  const ElasticTissue& tissue = table.SolidAt(label);
  FiniteStrainPatch& made = patches.emplace_back();
  made.first = static_cast<int>(shapes.size());
  made.count = static_cast<int>(patch.tetrahedra.size());
  made.shear_mpa = tissue.ShearModulusMpa();
  made.bulk_mpa = tissue.BulkModulusMpa();
  made.law = table.law[label];
  for (const int t : patch.tetrahedra) {
    shapes.push_back(LinearTetrahedronOf(mesh, t));
    made.volume_mm3 += shapes.back().volume_mm3;
    std::array<int, 4>& nodes = corners.emplace_back();
    for (int c = 0; c < 4; ++c) {
      const int node = mesh.tetrahedra(c, t);
      nodes[c] = node_of_mesh_node.empty() ? node : node_of_mesh_node[node];
    }
  }
}

void DeformAll(const FiniteStrainBody& body, const Eigen::Ref<const Eigen::Matrix3Xd>& u_mm,
               std::span<StrainedTetrahedron> out) noexcept {
  for (std::size_t t = 0; t < body.shapes.size(); ++t) {
    Corners34 u;
    for (int c = 0; c < 4; ++c) u.col(c) = u_mm.col(body.corners[t][c]);
    StrainedTetrahedron& state = out[t];
    state.gradient.noalias() = u * body.shapes[t].gradients_per_mm.transpose();
    state.gradient.diagonal().array() += 1.0;
    state.volume_ratio = state.gradient.determinant();
  }
  for (const FiniteStrainPatch& patch : body.patches) BalanceVolume(body, patch, out);
}

void AddMissingForces(const FiniteStrainBody& body, std::span<const StrainedTetrahedron> state,
                      Eigen::Ref<Eigen::Matrix3Xd> force_n) noexcept {
  for (const FiniteStrainPatch& patch : body.patches) {
    double change_mm3 = 0.0;
    for (int t = patch.first; t < patch.first + patch.count; ++t) {
      change_mm3 += body.shapes[t].volume_mm3 * (state[t].gradient.trace() - 3.0);
    }
    const double mean_mpa = patch.bulk_mpa * change_mm3 / patch.volume_mm3;
    for (int t = patch.first; t < patch.first + patch.count; ++t) {
      const LinearTetrahedron& shape = body.shapes[t];
      const Eigen::Matrix3d& f = state[t].gradient;
      Eigen::Matrix3d stress = patch.shear_mpa * (f + f.transpose());
      // 2 G dev(strain) + mean: the trace of F + F^T is 2 (3 + trace of the strain).
      stress.diagonal().array() += mean_mpa - patch.shear_mpa * 2.0 / 3.0 * f.trace();
      stress -= ShapeStressMpa(patch.law, patch.shear_mpa, f);
      stress -= state[t].pressure_mpa * Cofactor(f);
      const Corners34 g = shape.volume_mm3 * stress * shape.gradients_per_mm;
      Scatter(body.corners[t], g, force_n);
    }
  }
}

}  // namespace acus::mechanics
