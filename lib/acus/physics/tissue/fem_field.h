// Displacements for the image, from forces on 3D finite elements.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "acus/data/mesh/point_location.h"
#include "acus/data/mesh/tetra_mesh.h"
#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "acus/physics/tissue/tissue_load.h"

namespace acus::tissue {

/// What every FemField of a scene reads: which nodes the elements near the needle have, and what
/// forces do to them. Does not change.
class FemImage {
 public:
  /// Keeps what it needs of the mesh, and shares the numbers of `tissue`.
  /// @param tissue  Of this mesh. @throws InputError if it has no image block.
  FemImage(const mesh::TetraMesh& mesh, mechanics::CondensedTissue tissue);

 private:
  friend class FemField;
  struct Element {
    std::array<int, 4> image_row;  ///< Of each node, in the image block; -1: not stored.
    std::array<int, 4> reach_row;  ///< In the compliance; kHeld or kOutOfReach.
  };

  mechanics::CondensedTissue tissue_;
  std::vector<Element> elements_;  ///< Those with a stored node.
  mesh::PointLocation location_;   ///< Of these.
};

/// Displacements at one moment. Fields of one FemImage may be used by different threads.
///
/// Inside an element they are interpolated linearly between its nodes; nodes that are not stored
/// count as zero. So the field is continuous, exact at stored nodes (except for the storage in
/// float, about 1e-6 of the largest displacement), and zero away from them.
class FemField {
 public:
  explicit FemField(const FemImage& image);

  /// Nodal displacements by the point loads. Each load acts on the nodes of its element; one that
  /// is outside the mesh, or whose element has a node that is neither held nor reachable, is
  /// dropped. Allocates nothing. Cost: see docs/models/tissue_condensation.md.
  void Update(const TissueLoad& load) noexcept;

  /// Zero outside the elements with stored nodes, and where a coordinate is not a number.
  Eigen::Vector3d DisplacementMm(const Eigen::Vector3d& rest_in_ct_mm) const noexcept;

  /// Loads without room in the last Update.
  int num_dropped_loads() const { return num_dropped_; }

 private:
  void AddLoad(const PointLoad& load) noexcept;

  const FemImage* image_;
  std::vector<double> force_n_;         ///< By degree of freedom of the compliance.
  std::vector<int> loaded_;             ///< Rows of the compliance with a force.
  std::vector<float> displacement_mm_;  ///< x, y, z of each node of the image block.
  bool is_zero_ = true;
  int num_dropped_ = 0;
};

}  // namespace acus::tissue
