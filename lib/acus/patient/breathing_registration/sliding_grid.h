// Displacements on a grid that are smooth within the body, but may slide along a wall in it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::breathing_registration {

/// Which side of the wall tissue is on.
enum class Side : std::uint8_t { kNone, kWall, kCavity };

/// Nodes of a grid that are tissue, their neighbours, and the smoothness that ties them: all of the
/// difference of neighbours on the same side; across the wall a part of what is normal to it and
/// hardly anything of what is along it, so that tissue slides, but neither parts nor overlaps
/// (direction-dependent regularisation, Schmidt-Richberg et al. 2012).
class SlidingGrid {
 public:
  /// @param side    One for each node of `geometry`.
  /// @param normal  Unit normal of the wall at each node, along the grid's axes; used near the
  /// wall.
  SlidingGrid(const volume::Geometry& geometry, const std::vector<Side>& side,
              const std::vector<Eigen::Vector3f>& normal);

  /// Share of its smoothness that drags tissue along as it slides. Without it, the few nodes that
  /// the other side surrounds are free to go anywhere along the wall; more than a thousandth costs
  /// accuracy at the wall.
  static constexpr float kDrag = 1e-4F;

  /// Share of its smoothness that keeps tissue at the wall. Not all: what slides far along a wall
  /// that curves ends off the plane that touches it where it began.
  static constexpr float kNormalShare = 0.1F;

  using Field = std::vector<Eigen::Vector3f>;  ///< One vector for each node that is tissue.

  int num_nodes() const { return static_cast<int>(voxel_.size()); }
  const volume::Geometry& geometry() const { return geometry_; }
  std::size_t Voxel(int node) const { return voxel_[static_cast<std::size_t>(node)]; }
  Side SideOf(int node) const { return side_[static_cast<std::size_t>(node)]; }
  /// Place of a node, in voxels.
  Eigen::Vector3f IndexOf(int node) const;
  /// The node at a voxel; -1 where there is no tissue.
  std::int32_t NodeAt(std::size_t voxel) const { return node_at_[voxel]; }

  /// sum over the neighbours of node n of what ties it to them: row n of the Laplacian.
  Eigen::Vector3f Pull(const Field& u, int n) const noexcept {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    const auto& mine = u[static_cast<std::size_t>(n)];
    for (const std::int32_t m : neighbours_[static_cast<std::size_t>(n)]) {
      if (m < 0) continue;
      const Eigen::Vector3f difference = mine - u[static_cast<std::size_t>(m)];
      if (side_[static_cast<std::size_t>(m)] == side_[static_cast<std::size_t>(n)]) {
        sum += difference;
      } else {
        const Eigen::Vector3f normal = NormalBetween(n, m);
        sum += (kNormalShare - kDrag) * normal.dot(difference) * normal + kDrag * difference;
      }
    }
    return sum;
  }
  /// Calls use(m) for the nodes beside node n that are on its side.
  template <class Use>
  void ForNodesBeside(int n, const Use& use) const {
    for (const std::int32_t m : neighbours_[static_cast<std::size_t>(n)]) {
      if (m >= 0 && SideOf(m) == SideOf(n)) use(m);
    }
  }
  /// The block of that row on the diagonal.
  Eigen::Matrix3f Stiffness(int n) const noexcept;

  /// Field at a place (in voxels), from the nodes of that side around it; from any if there are
  /// none, zero if there is no tissue. Trilinear.
  Eigen::Vector3f At(const Field& u, const Eigen::Vector3f& index, Side side) const noexcept;

  /// Smallest determinant of the deformation gradient I + du/dx, by forward differences between
  /// nodes of the same side; <= 0 is a fold. None if no node has all three neighbours.
  std::optional<double> SmallestDeterminant(const Field& u) const;

  /// On all nodes of the grid: beyond the tissue as the nearest of it, layer by layer.
  std::vector<Eigen::Vector3f> Everywhere(const Field& u) const;

 private:
  Eigen::Vector3f NormalBetween(int n, int m) const noexcept {
    const Eigen::Vector3f sum =
        normal_[static_cast<std::size_t>(n)] + normal_[static_cast<std::size_t>(m)];
    const float length = sum.norm();
    return length > 1e-3F ? Eigen::Vector3f(sum / length) : Eigen::Vector3f::Zero();
  }

  volume::Geometry geometry_;
  std::vector<std::size_t> voxel_;
  std::vector<Side> side_;
  std::vector<Eigen::Vector3f> normal_;
  std::vector<std::array<std::int32_t, 6>> neighbours_;  ///< Before and after, axis by axis.
  std::vector<std::int32_t> node_at_;
};

/// For each node: weight_n * gradient_n * gradient_n^T, and a right-hand side.
struct DataTerm {
  std::vector<Eigen::Vector3f> gradient;  ///< Scaled by the root of its weight.
  SlidingGrid::Field force;
};

/// Solves (gradient gradient^T + stiffness * (Laplacian + 1e-4)) step = force by conjugate
/// gradients, preconditioned by the blocks on the diagonal; the 1e-4 damps steps of nodes that
/// nothing ties. The same bits for any number of threads.
SlidingGrid::Field SolveStep(const SlidingGrid& grid, const DataTerm& data, float stiffness,
                             int iterations, int num_threads);

}  // namespace acus::breathing_registration
