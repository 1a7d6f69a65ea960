// A tetrahedral mesh as contact sees it: where a place of the tissue at rest is in the compliance.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "acus/data/mesh/point_location.h"
#include "acus/data/mesh/tetra_mesh.h"
#include "acus/data/volume/volume.h"
#include "acus/physics/mechanics/condensation/compliance.h"
#include "acus/physics/tissue/contact_system.h"

namespace acus::tissue {

/// What is at a place of the tissue at rest.
struct Spot {
  bool inside = false;       ///< In a tetrahedron.
  bool reachable = false;    ///< All its nodes that move are in the compliance.
  volume::Label tissue = 0;  ///< 0 outside.
  double element_mm = 0.0;   ///< Edge of the regular tetrahedron of the same volume.
  ContactPlace place;        ///< Nodes that are fixed or out of reach count as held still.
};

class ContactMesh {
 public:
  ContactMesh(const mesh::TetraMesh& mesh, const mechanics::Compliance& compliance);

  /// Allocates nothing. On a face, edge or node: the tetrahedron with the lowest number.
  Spot Find(const Eigen::Vector3d& rest_in_ct_mm) const noexcept;

  /// Where the segment from a place outside to one inside crosses the surface, the inner side of
  /// it. To 1e-6 of the segment. @pre Find(outside) is outside, Find(inside) inside.
  Eigen::Vector3d Crossing(Eigen::Vector3d outside_mm, Eigen::Vector3d inside_mm) const noexcept;

 private:
  struct Element {
    std::array<int, 4> row;  ///< In the compliance; -1: held still.
    double size_mm;
    volume::Label tissue;
    bool reachable;
  };
  mesh::PointLocation location_;
  std::vector<Element> elements_;
};

/// A node of the surface that is in the compliance.
struct SurfaceNode {
  int row = 0;
  Eigen::Vector3d rest_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d inward_in_ct = Eigen::Vector3d::UnitZ();  ///< Against the outer normal; unit.
};

/// Nodes on faces that belong to one tetrahedron only, ascending by mesh node.
std::vector<SurfaceNode> ReachableSurface(const mesh::TetraMesh& mesh,
                                          const mechanics::Compliance& compliance);

}  // namespace acus::tissue
