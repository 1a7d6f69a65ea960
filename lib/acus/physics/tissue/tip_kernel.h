// Over which tissue the needle's tip acts: a ball inside, a disc on the surface, of a size that is
// the same for any mesh.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/tissue/contact_system.h"

namespace acus::tissue {

/// The mean over a kernel as a sum over nodes.
struct KernelPlace {
  ContactPlace place;
  /// A node that stands for others too is moved too far by its own force: what to take off, 1/mm,
  /// <= 0, times SphereMobilityMm2PerN. docs/models/tissue_membranes.md
  double self_per_mm = 0.0;
};

/// Const after construction; look-ups allocate nothing.
///
/// Weights are (1 - d^2 / R^2)^2 of the distance d, times the tissue that a node stands for: volume
/// in a ball, area in a disc. Of many nodes only some are taken, about R / 2.7 apart, each for
/// the tissue around it: coarse quadrature of a smooth function, whatever the mesh. Nodes that are
/// held count as held still.
class TipKernel {
 public:
  TipKernel(const mesh::TetraMesh& mesh, const mechanics::Compliance& compliance);

  /// No rows if no node is within `radius_mm`. O(nodes in reach).
  KernelPlace Ball(const Eigen::Vector3d& rest_in_ct_mm, double radius_mm) const noexcept;
  /// The same over the surface of the body.
  KernelPlace Disc(const Eigen::Vector3d& rest_in_ct_mm, double radius_mm) const noexcept;

  /// Position at rest of a row of the compliance.
  const Eigen::Vector3d& RestOf(int row) const noexcept {
    return rest_of_row_[static_cast<std::size_t>(row)];
  }

 private:
  struct Node {
    Eigen::Vector3d rest_in_ct_mm;
    int row;             ///< -1: held still.
    double share;        ///< mm^3 or mm^2 that it stands for.
    double self_per_mm;  ///< For a weight of 1, see KernelPlace; 0 in discs.
  };
  /// Nodes at least `spacing_mm` apart.
  struct Level {
    double spacing_mm = 0.0;
    std::vector<Node> node;
  };
  struct Quadrature;
  static KernelPlace Sum(const std::vector<Level>& levels, const Eigen::Vector3d& rest_in_ct_mm,
                         double radius_mm) noexcept;
  std::vector<Eigen::Vector3d> rest_of_row_;
  std::vector<Level> volume_, surface_;
};

}  // namespace acus::tissue
