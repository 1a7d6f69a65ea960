// Hounsfield units at any point of a CT, fast enough for whole images.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"

namespace acus::slicing {

/// Samples along scan lines, sample by sample: value(line, k) = row(k)[line].
/// Each row has margins of at least kMargin floats on both sides, so that windows across lines need
/// no special case at the borders.
class BeamImage {
 public:
  static constexpr int kMargin = 32;

  /// Allocates only if the size grows.
  void Resize(int lines, int samples);
  int lines() const { return lines_; }
  int samples() const { return samples_; }
  int stride() const { return stride_; }  ///< Floats per row, margins and all; a multiple of 16.

  /// Extends row k by copies of its first and last value.
  void FillMargins(int k);

  float* padded_row(int k) { return data_.data() + static_cast<std::ptrdiff_t>(k) * stride_; }
  const float* padded_row(int k) const {
    return data_.data() + static_cast<std::ptrdiff_t>(k) * stride_;
  }
  float* row(int k) { return padded_row(k) + kMargin; }
  const float* row(int k) const { return padded_row(k) + kMargin; }

 private:
  int lines_ = 0;
  int samples_ = 0;
  int stride_ = 0;
  image::AlignedFloats data_;
};

/// Trilinear interpolation; -1024 HU outside the volume, that is, more than half a voxel beyond
/// the outermost voxel centres. Deterministic: the same bits with any vector width and threads.
class CtSampler {
 public:
  static constexpr float kOutsideHu = -1024.0F;
  /// Distinguishes air from what was not scanned: below what a voxel can hold.
  static constexpr float kNotScanned = -65536.0F;

  /// Keeps a reference to `ct`, which must outlive this.
  /// @throws InputError if the volume is empty or has 2^30 voxels or more.
  explicit CtSampler(const volume::CtVolume& ct);

  /// At one point. Slow: for tests and single values. Interpolates in double.
  double At(const Eigen::Vector3d& ct_mm) const;

  /// Lines of `grid` as seen from a pose. Allocation-free once `lines` is large enough.
  /// @throws InputError if the pose has a value that is not finite.
  void PlaceLines(const acoustics::ScanGrid& grid, const Eigen::Isometry3d& ct_from_probe,
                  BeamLines& lines) const;

  /// Fills `hu`, resized before by the caller to fit the grid, without its margins, on up to
  /// `num_threads` threads. Where `bend` is active, samples lie off the lines.
  /// @param outside  Value outside the volume.
  void Sample(const BeamLines& lines, const BeamBend& bend, BeamImage& hu, int num_threads,
              float outside = kOutsideHu) const;

  /// For the kernels. Valid as long as this.
  kernels::Voxels Voxels(float outside = kOutsideHu) const;

  const Eigen::Affine3d& index_from_ct() const { return index_from_ct_; }

  const volume::Geometry& geometry() const { return ct_.geometry; }

 private:
  const volume::CtVolume& ct_;
  Eigen::Affine3d index_from_ct_;
  std::vector<std::int16_t> thickened_;  ///< Copy with doubled axes, where one has a single voxel.
  const std::int16_t* voxels_;
  Eigen::Array3i size_;
};

}  // namespace acus::slicing
