// The CT in the plane of the probe, with the needle: what the 2010 paper shows above the B-mode.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "ultrasound/ct_sampler.h"
#include "ultrasound/image.h"
#include "ultrasound/probe.h"
#include "volume/volume.h"

namespace acus::ultrasound {

/// Grey values: `centre_hu` is middle grey, `width_hu` from black to white.
struct HuWindow {
  double centre_hu = 40.0;
  double width_hu = 400.0;
};

/// Renders CT slices of one picture geometry. Not for two threads at a time: it holds buffers.
class CtSliceRenderer {
 public:
  /// Keeps a reference to `ct`, which must outlive this.
  /// @throws InputError if the picture has no pixel or the window no width.
  CtSliceRenderer(const volume::CtVolume& ct, const ImageGeometry& picture,
                  double slice_thickness_mm, const HuWindow& window = {});

  /// Allocation-free after the first call. The same bits with any `num_threads`.
  /// @throws InputError if the pose or the needle is not finite.
  /// @param rest  Where the tissue was at rest; null: it has not moved.
  void Render(const Eigen::Isometry3d& ct_from_probe, const std::optional<NeedleInImage>& needle,
              GrayImage& out, int num_threads = 1, const RestMap* rest = nullptr);

  /// Hounsfield units of the last Render, before windowing. row(r)[c] is pixel (c, r).
  const BeamImage& hu() const { return hu_; }
  const ImageGeometry& picture() const { return picture_; }

 private:
  CtSampler sampler_;
  ImageGeometry picture_;
  double slice_thickness_mm_;
  HuWindow window_;
  ScanGrid grid_;
  BeamLines lines_;
  BeamBend bend_;
  BeamImage hu_;
};

}  // namespace acus::ultrasound
