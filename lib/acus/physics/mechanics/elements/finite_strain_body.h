// Tetrahedra at large strain, in the patches that change their volume together: state and forces.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/mechanics/elements/element_patches.h"
#include "acus/physics/mechanics/elements/linear_tetrahedron.h"

namespace acus::mechanics {

/// One patch P and its tetrahedra [first, first + count). Its energy, N mm, with J_t = det F_t and
/// Jbar the mean of J_t by volume:
///   sum_t V_t W(F_t) + V_P K/2 (Jbar - 1)^2 + sum_t V_t kOwnVolume G (J_t - Jbar)^4.
/// The last term keeps single tetrahedra of a patch from collapsing; it is nothing near rest, where
/// the rest is the energy of ElementKind::kAveragedDilatation, and nothing where F is constant.
struct FiniteStrainPatch {
  int first = 0;
  int count = 0;
  double volume_mm3 = 0.0;
  double shear_mpa = 0.0;
  double bulk_mpa = 0.0;
  HyperelasticLaw law{};
};
inline constexpr double kOwnVolume = 10.0;

struct StrainedTetrahedron {
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();  ///< F.
  double volume_ratio = 1.0;                               ///< J = det F.
  double pressure_mpa = 0.0;  ///< Derivative of the patch's energy by J, over the volume.
};

struct FiniteStrainBody {
  std::vector<FiniteStrainPatch> patches;
  std::vector<std::array<int, 4>> corners;  ///< Node of each corner, in patch order.
  std::vector<LinearTetrahedron> shapes;

  /// @param node_of_mesh_node  Numbers of the nodes here; empty: as in the mesh.
  void Add(const mesh::TetraMesh& mesh, const ElasticityTable& table, const ElementPatch& patch,
           std::span<const int> node_of_mesh_node);
};

/// Deformation of all tetrahedra. @param u_mm  3 x nodes. @param out  One per tetrahedron.
void DeformAll(const FiniteStrainBody& body, const Eigen::Ref<const Eigen::Matrix3Xd>& u_mm,
               std::span<StrainedTetrahedron> out) noexcept;

/// Adds the forces that the linear model of the same patches needs to hold the nodes, less those
/// that the laws need: 0 at rest, of second order in the strain.
void AddMissingForces(const FiniteStrainBody& body, std::span<const StrainedTetrahedron> state,
                      Eigen::Ref<Eigen::Matrix3Xd> force_n) noexcept;

}  // namespace acus::mechanics
