// Sums over cubes of nodes, each side of the wall by itself.
#pragma once

#include <array>
#include <vector>

#include "acus/patient/breathing_registration/sliding_grid.h"

namespace acus::breathing_registration {

/// Sums of some numbers of the nodes over cubes of 2, 4, 8 ... nodes. Add all, finish, then ask.
class SidedSums {
 public:
  static constexpr int kNumbers = 5;
  using Numbers = Eigen::Array<float, kNumbers, 1>;

  /// @param size  Of the grid, in nodes.
  SidedSums(const Eigen::Array3i& size, int num_scales);
  void Add(const Eigen::Array3i& node, Side side, const Numbers& numbers);
  /// Makes the sums of the larger cubes.
  void Finish();

  /// Interpolated between the middles of cubes. @param at  In nodes. @param scale  0: 2 nodes.
  Numbers At(const Eigen::Vector3f& at, Side side, int scale) const noexcept;
  /// In cubes of two nodes.
  const Eigen::Array3i& size() const { return scales_.front().size; }

 private:
  struct Scale {
    Eigen::Array3i size;
    std::array<std::vector<Numbers>, 2> sums;  ///< Wall, cavity.
  };
  std::vector<Scale> scales_;
};

/// Where a side is in arrays of two.
inline std::size_t SideIndex(Side side) {
  return side == Side::kCavity ? 1 : 0;
}

/// Index of a cube in an array of `size`.
inline std::size_t CubeAt(const Eigen::Array3i& size, const Eigen::Array3i& at) {
  return (static_cast<std::size_t>(at[2]) * static_cast<std::size_t>(size[1]) +
          static_cast<std::size_t>(at[1])) *
             static_cast<std::size_t>(size[0]) +
         static_cast<std::size_t>(at[0]);
}

/// Calls use(index, weight) for the cubes whose middles are around a place, trilinear.
template <class Use>
void AroundCubes(const Eigen::Array3i& size, const Eigen::Vector3f& at_nodes, int nodes_per_cube,
                 const Use& use) {
  const Eigen::Array3f index =
      ((at_nodes.array() + 0.5F) / static_cast<float>(nodes_per_cube) - 0.5F)
          .max(0.0F)
          .min((size - 1).cast<float>());
  const Eigen::Array3i base = index.cast<int>().min(size - 2).max(0);
  const Eigen::Array3f t = index - base.cast<float>();
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3i bit(corner & 1, (corner >> 1) & 1, corner >> 2);
    const Eigen::Array3i cube = base + bit;
    if ((cube >= size).any()) continue;
    use(CubeAt(size, cube), (bit != 0).select(t, 1.0F - t).prod());
  }
}

}  // namespace acus::breathing_registration
