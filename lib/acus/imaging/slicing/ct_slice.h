// The CT in the plane of the probe, with the needle: what the 2010 paper shows above the B-mode.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/ct_sampler.h"

namespace acus::slicing {

/// Grey values: `centre_hu` is middle grey, `width_hu` from black to white.
struct HuWindow {
  double centre_hu = 40.0;
  double width_hu = 400.0;
};

/// Renders CT slices of one image geometry. Not for two threads at a time: it holds buffers.
class CtSliceRenderer {
 public:
  /// Keeps a reference to `ct`, which must outlive this.
  /// @throws InputError if the image has no pixel or the window no width.
  CtSliceRenderer(const volume::CtVolume& ct, const image::ImageGeometry& image,
                  double slice_thickness_mm, const HuWindow& window = {});

  /// Allocation-free after the first call. The same bits with any `num_threads`.
  /// @throws InputError if the pose or the needle is not finite.
  /// @param rest  Where the tissue was at rest; null: it has not moved.
  void Render(const Eigen::Isometry3d& ct_from_probe,
              const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
              int num_threads = 1, const RestMap* rest = nullptr);

  /// Hounsfield units of the last Render, before windowing. row(r)[c] is pixel (c, r).
  const BeamImage& hu() const { return hu_; }
  const image::ImageGeometry& image() const { return image_; }

 private:
  void ShowRow(int r, image::GrayImage& out) const;

  CtSampler sampler_;
  image::ImageGeometry image_;
  double slice_thickness_mm_;
  HuWindow window_;
  acoustics::ScanGrid grid_;
  BeamLines lines_;
  BeamBend bend_;
  BeamImage hu_;
};

}  // namespace acus::slicing
