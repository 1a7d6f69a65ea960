// The inverse of breath for one image, on the corners of the blocks that rays visit: where it is
// smooth, samples read it instead of inverting for themselves.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "acus/imaging/volume_rendering/visible_blocks.h"
#include "acus/imaging/volume_rendering/warped_ray.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::volume_rendering {

/// Offsets from a place of the world to where its tissue was at rest, in voxels of the CT,
/// trilinear within a block. A block is smooth if |X + u(X) - x| of what it says is within the
/// tolerance at five places in it; others, such as those where organs slide, are for WarpedRay.
class WarpLattice {
 public:
  /// For a moment, whatever was before: the same values with any number of threads. Allocates only
  /// if the blocks grow.
  /// @param tolerance_mm  0: no block is smooth, nothing is done.
  void Update(const breathing::MotionMap& motion, const VisibleBlocks& blocks,
              const Eigen::Affine3d& index_from_ct, double tolerance_mm, int num_threads);
  /// No block is smooth.
  void Clear() { smooth_.clear(); }

  /// @param block  Within the blocks, visible.
  bool IsSmooth(const Eigen::Array3i& block) const noexcept {
    return !smooth_.empty() && smooth_[static_cast<std::size_t>(
                                   (block[2] * size_[1] + block[1]) * size_[0] + block[0])] != 0;
  }
  /// @param in_blocks  A place in that block. @pre it is smooth.
  Eigen::Vector3f OffsetAt(const Eigen::Array3i& block,
                           const Eigen::Vector3f& in_blocks) const noexcept {
    const Eigen::Array3f share = in_blocks.array() - block.cast<float>();
    const std::ptrdiff_t row = size_[0] + 1;
    const std::ptrdiff_t slice = row * (size_[1] + 1);
    const Knot* corner = knots_.data() + slice * block[2] + row * block[1] + block[0];
    const auto along = [&](const Knot* at) { return Knot(at[0] + share[0] * (at[1] - at[0])); };
    const Knot near_low = along(corner);
    const Knot near = near_low + share[1] * (along(corner + row) - near_low);
    const Knot far_low = along(corner + slice);
    const Knot far = far_low + share[1] * (along(corner + slice + row) - far_low);
    return Knot(near + share[2] * (far - near)).head<3>();
  }
  /// IsSmooth of all blocks, i fastest; null: none is.
  const std::uint8_t* smooth() const noexcept { return smooth_.empty() ? nullptr : smooth_.data(); }
  /// Four numbers for each corner of a block, i fastest, where blocks are smooth.
  const float* knots() const noexcept { return knots_.empty() ? nullptr : knots_.front().data(); }
  /// Share of the visible blocks that are smooth.
  double SmoothShare() const noexcept { return smooth_share_; }

 private:
  using Knot = Eigen::Array4f;  ///< In voxels; the fourth is not used.

  /// Memory of one slice of knots or blocks.
  struct Slice {
    std::vector<int> number;  ///< Of the knots, or blocks, that matter.
    Eigen::Matrix3Xf place_mm;
    Eigen::Matrix3Xf rest_mm;
    Eigen::Matrix3Xf moved_mm;
    int num_visible = 0;
    int num_smooth = 0;
  };

  void InvertSlice(const breathing::MotionMap& motion, const VisibleBlocks& blocks, int k);
  void JudgeSlice(const breathing::MotionMap& motion, const VisibleBlocks& blocks, int k);
  bool TouchesVisible(const VisibleBlocks& blocks, const Eigen::Array3i& knot) const noexcept;

  Eigen::Array3i size_ = Eigen::Array3i::Zero();  ///< Of the blocks.
  Eigen::Affine3f ct_from_blocks_ = Eigen::Affine3f::Identity();
  Eigen::Matrix3f index_from_mm_ = Eigen::Matrix3f::Identity();
  Eigen::Matrix3f mm_from_index_ = Eigen::Matrix3f::Identity();
  double tolerance_mm_ = 0.0;
  std::vector<Knot> knots_;
  std::vector<std::uint8_t> smooth_;  ///< By block.
  std::vector<Slice> slices_;
  double smooth_share_ = 0.0;
};

}  // namespace acus::volume_rendering
