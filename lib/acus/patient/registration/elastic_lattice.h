// Smooth displacements: an elastic body on a regular lattice, pulled by springs.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <span>
#include <vector>

namespace acus::registration {

/// Displacements at the nodes of a lattice along the axes of CT space, trilinear between them,
/// beyond the lattice as at its border. A value; const access from any number of threads.
class LatticeField {
 public:
  LatticeField() = default;
  /// Nothing moves yet. @pre box is not empty, spacing_mm > 0.
  LatticeField(const Eigen::AlignedBox3d& box, double spacing_mm);

  /// mm in CT space, at a place before the displacement.
  Eigen::Vector3d At(const Eigen::Vector3d& rest_mm) const noexcept;
  /// d place / d rest in the cell of a place.
  Eigen::Matrix3d GradientAt(const Eigen::Vector3d& rest_mm) const noexcept;

  const Eigen::Vector3d& origin_mm() const { return origin_mm_; }
  double spacing_mm() const { return spacing_mm_; }
  const Eigen::Array3i& size() const { return size_; }  ///< Nodes.
  std::vector<Eigen::Vector3d>& nodes_mm() { return nodes_mm_; }
  const std::vector<Eigen::Vector3d>& nodes_mm() const { return nodes_mm_; }
  std::size_t Index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * size_[1] + j) * size_[0] + i;
  }
  Eigen::Vector3d PlaceMm(int i, int j, int k) const {
    return origin_mm_ + spacing_mm_ * Eigen::Vector3d(i, j, k);
  }

  /// The eight nodes around a place and their weights, for what is made from the field.
  struct Cell {
    std::size_t node[8];
    double weight[8];
  };
  Cell CellAt(const Eigen::Vector3d& rest_mm) const noexcept;

 private:
  Eigen::Vector3d origin_mm_ = Eigen::Vector3d::Zero();
  double spacing_mm_ = 1.0;
  Eigen::Array3i size_ = Eigen::Array3i::Constant(2);
  std::vector<Eigen::Vector3d> nodes_mm_ = std::vector<Eigen::Vector3d>(8, Eigen::Vector3d::Zero());
};

/// Pulls the displacement at a place towards `pull_mm` along a direction; free across it.
struct Spring {
  Eigen::Vector3d rest_mm;
  Eigen::Vector3d direction;  ///< Unit.
  double pull_mm = 0.0;
  double stiffness = 1.0;  ///< Force per mm, in the unit of Young's modulus times mm.
};

/// Linear elasticity (Poisson 0.3) with trilinear cubes, each with its own Young's modulus in any
/// one unit. Small strains and turns: right for what remains after a rigid registration.
class ElasticLattice {
 public:
  /// @param modulus  At a place, > 0; averaged over eight places of each cell.
  ElasticLattice(const LatticeField& lattice,
                 const std::function<double(const Eigen::Vector3d&)>& modulus, int num_threads);

  /// Solves for the displacements at rest under the springs, from those in `field`, by conjugate
  /// gradients, until no node would move by more than 1e-5 mm if its neighbours stayed. The same
  /// bits for any number of threads.
  /// @returns the number of iterations; the limit of 2000 if it was not enough.
  int Solve(std::span<const Spring> springs, LatticeField& field, int num_threads) const;

 private:
  using Vectors = std::vector<Eigen::Vector3d>;
  void Multiply(const Vectors& u, Vectors& force, int num_threads) const;
  std::vector<Eigen::Matrix3d> Diagonal() const;

  LatticeField lattice_;
  std::vector<double> modulus_;            ///< Per cell, i fastest.
  Eigen::Matrix<double, 24, 24> element_;  ///< Of a cube with this spacing and modulus 1.
};

}  // namespace acus::registration
