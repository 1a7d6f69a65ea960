// Where the nodes of a graded mesh begin: a body-centred lattice on a balanced octree.
#pragma once

#include <Eigen/Dense>
#include <optional>

#include "acus/patient/meshing/interface_shape.h"
#include "acus/patient/meshing/material_field.h"

namespace acus::meshing {

/// The way of the needle, refined: a cylinder with round ends. Grid frame inside this module.
struct Corridor {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_mm = Eigen::Vector3d::Zero();
  double radius_mm = 15.0;
  double element_size_mm = 4.0;
};

/// Required length of edges, mm.
struct ElementSizes {
  double interface_mm = 6.0;  ///< At interfaces inside the body: bone.
  double skin_mm = 10.0;      ///< At the body's surface.
  double interior_mm = 20.0;  ///< Away from all of these.
  std::optional<Corridor> corridor;
  /// Elements become this small where interfaces are rougher than a tolerance; 0: nowhere.
  double finest_mm = 0.0;
};

/// The octree's blocks of all levels. @throws InputError if the elements are too small for memory.
BlockGrid BlocksOf(const MaterialField& field, const ElementSizes& sizes);

/// Where blocks are too large for the shape of the interfaces in them.
struct ShapeLimit {
  const InterfaceShape* shape = nullptr;  ///< Of the grid that BlocksOf gives; null: no limit.
  /// A block is divided if its size times its roughness [voxels] is above this: what is gained
  /// there by the same number of new nodes. So thin vessels do not take all from the rest.
  double gain_mm = 1.0;
};

/// Corners and centres of the leaves of an octree whose leaves are no larger than the size required
/// there and at most twice as large as any leaf that touches them; the body and one layer of leaves
/// around it. Where leaves are equal the points are a body-centred cubic lattice, whose Delaunay
/// tetrahedra have dihedral angles of 60 and 90 degrees (Labelle & Shewchuk 2007).
/// @throws InputError if more than `max_points` would be needed.
Eigen::Matrix3Xd LatticePoints(const MaterialField& field, const ElementSizes& sizes,
                               const ShapeLimit& limit, std::size_t max_points);

}  // namespace acus::meshing
