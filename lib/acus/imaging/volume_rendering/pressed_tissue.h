// Tissue that tools press, at one moment of a view in three dimensions.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "acus/base/math/inverse_map.h"

namespace acus::volume_rendering {

/// The last part of the map from the patient at rest to now: rest -> (breath) -> breathed ->
/// (tools) -> world. Holds the offsets d(x) from a place x of the world to where its tissue would
/// be if only breath moved it, trilinear between the knots of a grid; zero outside of that and at
/// its border, so that it is continuous everywhere.
///
/// A plain value. Reading it allocates nothing; any number of threads may.
class PressedTissue {
 public:
  /// The tissue that is at `world_mm` now, as breath alone would have it.
  /// @param guess_mm  Where to begin to look: what a neighbour gave, moved along.
  using Breathed = std::function<Eigen::Vector3d(const Eigen::Vector3d& world_mm,
                                                 const Eigen::Vector3d& guess_mm)>;

  /// Nothing is pressed.
  PressedTissue() = default;
  /// Asks `breathed` at each knot, row after row: the same values with any number of threads.
  /// @param box_in_ct_mm  What is pressed lies within it; empty: nothing is pressed.
  /// @param spacing_mm  Of the knots; > 0. @throws InputError if that gives more than 4 million.
  PressedTissue(const Eigen::AlignedBox3d& box_in_ct_mm, double spacing_mm,
                const Breathed& breathed, int num_threads);

  /// True: every map returns its argument.
  bool empty() const noexcept { return knots_.empty(); }
  /// CT space; nothing is pressed outside of it.
  const Eigen::AlignedBox3f& box_in_ct_mm() const noexcept { return box_; }
  /// The largest of all knots' |d|.
  float LargestMm() const noexcept { return largest_mm_; }
  /// d at the knots, x fastest; the first one is at the box's low corner.
  const std::vector<Eigen::Vector3f>& knots() const noexcept { return knots_; }
  const Eigen::Array3i& size() const noexcept { return size_; }
  float spacing_mm() const noexcept { return spacing_mm_; }

  bool Contains(const Eigen::Vector3f& world_mm) const noexcept { return box_.contains(world_mm); }
  /// d(world_mm), mm.
  Eigen::Vector3f OffsetMm(const Eigen::Vector3f& world_mm) const noexcept;
  /// d breathed / d world, from differences over a spacing of the knots.
  Eigen::Matrix3f GradientAt(const Eigen::Vector3f& world_mm) const noexcept;

  static constexpr math::InverseSettings kInverse{.max_iterations = 40, .tolerance_mm = 0.02};
  /// Solves x + d(x) = breathed_mm for x, by the fixed point of math::InvertDisplacement to 0.02 mm
  /// in at most 40 iterations. Where the map folds: the best place met, with its residual.
  math::InversePoint WorldMm(const Eigen::Vector3d& breathed_mm) const noexcept;

 private:
  Eigen::AlignedBox3f box_;
  Eigen::Array3i size_ = Eigen::Array3i::Zero();  ///< Knots along x, y, z.
  float spacing_mm_ = 1.0F;
  float largest_mm_ = 0.0F;
  std::vector<Eigen::Vector3f> knots_;  ///< x runs fastest.
};

}  // namespace acus::volume_rendering
