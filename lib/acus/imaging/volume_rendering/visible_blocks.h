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

/// Where the blocks of the world are at a moment.
struct BlockFrame {
  Eigen::Array3i margin = Eigen::Array3i::Zero();  ///< Blocks around those of the volume.
  Eigen::Array3i size = Eigen::Array3i::Zero();
  Eigen::Affine3f blocks_from_ct = Eigen::Affine3f::Identity();
  Eigen::Array3f reach =
      Eigen::Array3f::Zero();  ///< What a block shows besides its motion, blocks.
};

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

  /// A frame that holds all that Update() may mark at a moment. In constant time: for devices that
  /// mark blocks themselves.
  BlockFrame FrameFor(const breathing::MotionMap* motion, double ray_step_mm) const;

  /// Lowest and highest displacement anywhere in a block.
  struct Range {
    Eigen::Array3f low_mm;
    Eigen::Array3f high_mm;
  };
  /// Visible blocks of the patient at rest, and for each of these num_components() ranges.
  const std::vector<Eigen::Array3i>& visible() const { return visible_; }
  const std::vector<Range>& ranges_mm() const { return ranges_mm_; }
  int num_components() const { return num_components_; }
  const Eigen::Matrix3f& blocks_per_mm() const { return blocks_per_mm_; }

  /// World place to block coordinates, as floats.
  const Eigen::Affine3f& blocks_from_ct() const { return frame_.blocks_from_ct; }
  /// How far the nearest visible block is, in blocks in the sense of the largest coordinate; 0 if
  /// this one is visible. The block must be within [0, size()).
  int DistanceOf(const Eigen::Array3i& block) const noexcept {
    const Eigen::Array3i& size = frame_.size;
    return distance_[static_cast<std::size_t>((block[2] * size[1] + block[1]) * size[0] +
                                              block[0])];
  }
  const Eigen::Array3i& size() const { return frame_.size; }
  /// DistanceOf, i fastest; 3 more bytes may be read. @pre something is visible.
  const std::uint8_t* distances() const noexcept { return distance_.data(); }
  /// Box of the patient at rest, CT space; the whole volume if nothing is visible.
  Eigen::AlignedBox3d VisibleBox() const;
  bool nothing_visible() const { return visible_.empty(); }

 private:
  /// How far a block's content goes, in blocks.
  struct Shift {
    Eigen::Array3f low;
    Eigen::Array3f high;
  };

  void FindVisible(const volume::CtVolume& ct, const TransferFunction& transfer,
                   const TissueClasses& classes);
  void FindRanges(const volume::CtVolume& ct, const breathing::MotionField& field);
  static Range RangeNow(const Range* of_components, const breathing::MotionWeights& weights);
  Shift ShiftOf(const Range* of_components, const breathing::MotionMap* motion,
                const Eigen::Array3f& reach) const;
  void Mark(const Eigen::Array3i& low, const Eigen::Array3i& high);
  void SpreadDistance();

  Eigen::Affine3d index_from_ct_;
  Eigen::Array3i voxels_per_block_;
  Eigen::Matrix3f blocks_per_mm_;
  Eigen::Array3i rest_size_;
  std::vector<Eigen::Array3i> visible_;
  int num_components_ = 0;
  std::vector<Range> ranges_mm_;        ///< num_components_ for each of visible_.
  std::vector<Range> whole_ranges_mm_;  ///< By component, of all of them.

  BlockFrame frame_;
  std::vector<std::uint8_t> distance_;
  bool still_ = false;  ///< distance_ is that of the patient at rest, for step_mm_.
  double step_mm_ = 0.0;
};

}  // namespace acus::volume_rendering
