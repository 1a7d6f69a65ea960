// Which parts of space can hold something visible of a volume, also while it breathes: rays jump
// over the others.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/imaging/volume_rendering/transfer_function.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::volume_rendering {

/// The volume in blocks of about 6 mm. Blocks of the patient at rest are known from the voxels; the
/// blocks of the world that they can reach are found for each moment, with bounds that hold: the
/// displacement anywhere in a cell lies between those of its nodes.
class VisibleBlocks {
 public:
  /// @param ct  As are the others: must outlive this.
  /// @param field  Null if the patient does not breathe.
  VisibleBlocks(const volume::CtVolume& ct, const TransferFunction& transfer,
                const breathing::MotionField* field, const TissueClasses& classes = {});

  /// For a moment, whatever was before. Allocates only while motion grows.
  /// @param motion  Null, or of the field given before.
  /// @param ray_step_mm  Samples on a ray are this far apart.
  void Update(const breathing::MotionMap* motion, double ray_step_mm);

  /// Besides, what is visible may be seen this far from where Update() expects it, within a box:
  /// tools press the tissue there. After Update().
  void Widen(const Eigen::AlignedBox3f& box_in_ct_mm, float by_mm);

  /// World place to block coordinates, as floats.
  const Eigen::Affine3f& blocks_from_ct() const { return blocks_from_ct_; }
  /// How far the nearest visible block is, in blocks in the sense of the largest coordinate; 0 if
  /// this one is visible. The block must be within [0, size()).
  int DistanceOf(const Eigen::Array3i& block) const noexcept {
    return distance_[static_cast<std::size_t>((block[2] * size_[1] + block[1]) * size_[0] +
                                              block[0])];
  }
  const Eigen::Array3i& size() const { return size_; }
  /// DistanceOf, i fastest; 3 more bytes may be read. @pre something is visible.
  const std::uint8_t* distances() const noexcept { return distance_.data(); }
  /// Box of the patient at rest, CT space; the whole volume if nothing is visible.
  Eigen::AlignedBox3d VisibleBox() const;
  bool nothing_visible() const { return visible_.empty(); }

 private:
  struct RestBlock {
    Eigen::Array3i at;
    std::size_t range = 0;  ///< First of its ranges in ranges_mm_.
  };
  struct Range {
    Eigen::Array3f low_mm;
    Eigen::Array3f high_mm;
  };

  /// How far a block's content goes, in blocks.
  struct Shift {
    Eigen::Array3f low;
    Eigen::Array3f high;
  };

  void FindVisible(const volume::CtVolume& ct, const TransferFunction& transfer,
                   const TissueClasses& classes);
  void FindRanges(const volume::CtVolume& ct, const breathing::MotionField& field);
  Range RangeNow(const RestBlock& block, const breathing::MotionWeights& weights) const;
  Shift ShiftOf(const RestBlock& block, const breathing::MotionMap* motion,
                const Eigen::Array3f& reach) const;
  void Resize(const Eigen::Array3i& margin_blocks);
  void Mark(const Eigen::Array3i& low, const Eigen::Array3i& high);
  void SpreadDistance();

  Eigen::Affine3d index_from_ct_;
  Eigen::Array3i voxels_per_block_;
  Eigen::Matrix3f blocks_per_mm_;
  Eigen::Array3i rest_size_;
  std::vector<RestBlock> visible_;
  int num_components_ = 0;
  std::vector<Range> ranges_mm_;  ///< num_components_ for each of visible_.

  Eigen::Array3i margin_ = Eigen::Array3i::Constant(-1);  ///< Blocks around those of the volume.
  Eigen::Array3i size_ = Eigen::Array3i::Zero();
  Eigen::Affine3f blocks_from_ct_ = Eigen::Affine3f::Identity();
  std::vector<std::uint8_t> distance_;
  bool still_ = false;  ///< distance_ is that of the patient at rest, for step_mm_.
  double step_mm_ = 0.0;
};

}  // namespace acus::volume_rendering
