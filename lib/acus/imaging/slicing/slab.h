// Slices of a CT of any thickness, in any plane.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/slicing/ct_sampler.h"
#include "acus/imaging/slicing/ct_slice.h"

namespace acus::slicing {

/// What a slab shows of the Hounsfield units along its normal.
enum class SlabValue { kMean, kMaximum };

struct SlabSettings {
  double thickness_mm = 0.0;  ///< 0: one slice.
  SlabValue value = SlabValue::kMean;
  HuWindow window = {};
};

/// Renders slabs of one image geometry: slices less than a voxel apart, across the whole thickness,
/// through tissue that breath and tools move. Not for two threads at a time: it holds buffers.
class SlabRenderer {
 public:
  /// Slices closer than this to each other share what the rest map says, 2 mm.
  static constexpr double kSameRestMm = 2.0;

  /// Keeps a reference to `ct`, which must outlive this.
  /// @throws InputError if the image has no pixel, the window no width, or the thickness is not 0
  ///     to 200 mm.
  SlabRenderer(const volume::CtVolume& ct, const image::ImageGeometry& geometry,
               const SlabSettings& settings);

  /// @param ct_from_plane  Columns run along +x, rows along +y; the slab's normal is z.
  /// @param needle  Drawn where it is in the slab, or within 1 mm of a single slice.
  /// @param rest  Where the tissue was at rest; null: it has not moved.
  /// Allocation-free after the first call. The same bits with any `num_threads`.
  /// @throws InputError if the pose or the needle is not finite.
  void Render(const Eigen::Isometry3d& ct_from_plane,
              const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
              int num_threads = 1, const RestMap* rest = nullptr);

  /// Hounsfield units of the last Render, before windowing. row(r)[c] is pixel (c, r).
  const BeamImage& hu() const { return sum_; }
  int num_slices() const { return num_slices_; }

 private:
  void Add(int slice);

  CtSampler sampler_;
  image::ImageGeometry geometry_;
  SlabSettings settings_;
  acoustics::ScanGrid grid_;
  BeamLines lines_;
  BeamBend bend_;
  BeamImage slice_;
  BeamImage sum_;
  int num_slices_ = 1;
};

}  // namespace acus::slicing
