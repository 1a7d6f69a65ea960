// The CT as fluoroscopy reads it: attenuation in slices across the beam, coarser if required, and
// as the tissue is now.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/imaging/fluoroscopy/ray_sum_kernel.h"
#include "acus/imaging/slicing/beam_bend.h"

namespace acus::fluoroscopy {

/// Values are 1000 mu / mu_water = HU + 1000, at least 0 (and 0 outside). A copy: the CT need not
/// outlive it.
class AttenuationVolume {
 public:
  /// Slices lie across that axis of the CT which is nearest to `beam_in_ct` (unit).
  /// @param detail  Voxels are means over boxes whose edges are about this times the shortest edge
  ///     of a voxel of the CT.
  /// @throws InputError if the volume is empty, or one slice has 2^29 voxels or more.
  AttenuationVolume(const volume::CtVolume& ct, int detail, const Eigen::Vector3d& beam_in_ct,
                    int num_threads);

  /// Moves tissue to where it is now: each place shows what was there at rest. Linear between knots
  /// that are at most rest->SpacingMm() apart (but at least one voxel). Only voxels near moved
  /// knots are touched, and put back by the next call. Null: tissue at rest. The first call with a
  /// map that moves something allocates.
  void Deform(const slicing::RestMap* rest, int num_threads);

  /// Continuous (a, b, slice) of a place, as RaySums counts them, borders and all.
  const Eigen::Affine3d& slices_from_ct() const { return slices_from_ct_; }
  kernels::Slices slices() const;
  int num_slices() const { return size_[2]; }
  std::size_t bytes() const { return (base_.size() + now_.size()) * sizeof(std::int16_t); }

 private:
  void EvaluateKnots(const slicing::RestMap& rest, int num_threads);
  void MoveBlock(const Eigen::Array3i& block);
  void RestoreBlock(const Eigen::Array3i& block);
  std::int16_t SampleBase(const Eigen::Vector3f& place) const;
  std::size_t Index(int a, int b, int n) const;

  Eigen::Array3i size_;  ///< a and b with their borders.
  Eigen::Array3d voxel_mm_;
  Eigen::Affine3d slices_from_ct_;
  std::vector<std::int16_t> base_;
  std::vector<std::int16_t> now_;  ///< As deformed; empty until something moves.

  Eigen::Array3i block_ = Eigen::Array3i::Zero();   ///< Voxels from knot to knot.
  Eigen::Array3i blocks_ = Eigen::Array3i::Zero();  ///< Number along each axis.
  std::vector<Eigen::Vector3f> offset_;             ///< At knots, to the rest place, in voxels.
  std::vector<std::uint8_t> knot_moved_;
  std::vector<std::uint8_t> block_moved_;  ///< By the last call.
};

}  // namespace acus::fluoroscopy
