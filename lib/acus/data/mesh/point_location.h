// Which tetrahedron a point is in.
#pragma once

#include <Eigen/Dense>
#include <optional>
#include <vector>

#include "acus/data/mesh/tetra_mesh.h"

namespace acus::mesh {

struct Location {
  int tetrahedron = -1;
  Eigen::Vector4d weights = Eigen::Vector4d::Zero();  ///< Barycentric, >= 0, sum 1.
};

/// A grid over the mesh. Looking up neither allocates nor depends on earlier look-ups.
class PointLocation {
 public:
  /// Keeps a copy of what it needs; the mesh may go.
  /// @param tetrahedra_per_cell  Of the grid: fewer find faster and take more memory (2: 50 bytes a
  ///     tetrahedron beside 100 for its shape, 0.25: 250). What is found does not depend on it.
  /// @throws InputError if the mesh is empty.
  explicit PointLocation(const TetraMesh& mesh, double tetrahedra_per_cell = 2.0);

  /// The tetrahedron that holds the point; on a face, edge or node the one with the lowest number.
  /// Points outside by less than 1e-9 of a tetrahedron's height count as inside.
  std::optional<Location> Find(const Eigen::Vector3d& x_mm) const noexcept;

 private:
  struct Frame {
    Eigen::Vector3d first;               ///< Corner 0.
    Eigen::Matrix3d weights_from_place;  ///< Gives the weights of corners 1 to 3.
  };
  Eigen::Vector3i CellOf(const Eigen::Vector3d& x_mm) const;
  std::size_t Index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * size_[1] + j) * size_[0] + i;
  }

  std::vector<Frame> frames_;
  Eigen::Vector3d low_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d high_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d cell_mm_ = Eigen::Vector3d::Ones();
  Eigen::Vector3i size_ = Eigen::Vector3i::Ones();
  std::vector<int> first_;  ///< Of each cell, into members_.
  std::vector<int> members_;
};

}  // namespace acus::mesh
