// What images are timed on: a CT as large as a real abdomen, probes whose images lie in it
// entirely, and a hand that moves and tilts.
#pragma once

#include <cmath>
#include <cstdint>

#include "acus/data/image/image.h"
#include "acus/imaging/acoustics/probe.h"
#include "acus/imaging/slicing/beam_bend.h"
#include "support/synthetic_ct.h"

namespace acus::testing_support {

/// 512 x 512 x 300 voxels of 0.7 mm: air above y = 100 mm, then tissue with the noise of a CT, and
/// a bar of bone along z.
inline volume::CtVolume AbdomenCt() {
  std::uint32_t random = 1;
  return SyntheticCt({512, 512, 300}, 0.7, [&random](double x, double y, double) {
    random = random * 1664525U + 1013904223U;
    const double noise = 40.0 * ((random >> 8) / 16777216.0 - 0.5);
    if (y < 100.0) return -1000.0;
    return std::hypot(x - 180.0, y - 130.0) < 6.0 ? 700.0 : 50.0 + noise;
  });
}

/// 512 x 512 pixels, 512 lines of 512 samples: no black side saves anything.
inline acoustics::Probe FullLinearProbe() {
  return {.name = "full image",
          .kind = acoustics::ProbeKind::kLinear,
          .frequency_mhz = 10,
          .scan_lines = 512,
          .width_mm = 60.2,
          .depth_mm = 60.0,
          .image_width_px = 512,
          .image_height_px = 512,
          .slice_thickness_mm = 3,
          .pulse_length_mm = 0.7,
          .beam_width_mm = 1.2,
          .dynamic_range_db = 60,
          .gain_db = 6};
}

/// The n-th pose: each image reads other voxels. All are oblique to the voxels' axes.
inline Eigen::Isometry3d SwayingProbe(int n) {
  return Eigen::Translation3d(180 + 5 * std::sin(0.02 * n), 99.9, 100 + 20 * std::sin(0.01 * n)) *
         Eigen::AngleAxisd(0.3 + 0.1 * std::sin(0.03 * n), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitX());
}

/// In the plane of that pose.
inline image::NeedleInImage NeedleInPlane(const Eigen::Isometry3d& ct_from_probe) {
  image::NeedleInImage needle;
  needle.tip_in_ct_mm = ct_from_probe * Eigen::Vector3d(-10, 20, 0.2);
  needle.axis_in_ct = ct_from_probe.linear() * Eigen::Vector3d(0.8, 0.6, 0.0);
  needle.length_mm = 90;
  needle.radius_mm = 0.45;
  return needle;
}

/// A patient who breathes, and a needle that takes tissue along: everything in the image has
/// moved, and moves again with each image.
class BreathingAndNeedle : public slicing::RestMap {
 public:
  BreathingAndNeedle(int n, const Eigen::Vector3d& tip_in_ct_mm)
      : breath_mm_(4.0 * std::sin(0.05 * n)), tip_mm_(tip_in_ct_mm) {}
  Eigen::Vector3d RestInCtMm(const Eigen::Vector3d& place_mm,
                             const Eigen::Vector3d& /*guess_mm*/) const noexcept override {
    const double breath = breath_mm_ * std::cos(0.01 * place_mm.x());
    const double near = std::exp(-(place_mm - tip_mm_).squaredNorm() / 200.0);
    return place_mm - Eigen::Vector3d(0.1 * breath, 1.2 * near, breath);
  }
  double SpacingMm() const noexcept override { return 2.0; }

 private:
  double breath_mm_;
  Eigen::Vector3d tip_mm_;
};

/// The beam model's probe: `lines` of `samples` over the same image as FullLinearProbe.
inline acoustics::Probe FullBeamProbe(int lines, int samples) {
  acoustics::Probe probe = acoustics::DefaultProbe();
  const acoustics::Probe full = FullLinearProbe();
  probe.kind = full.kind;
  probe.frequency_mhz = 7.5;
  probe.scan_lines = lines;
  probe.samples_per_line = samples;
  probe.width_mm = full.width_mm;
  probe.depth_mm = full.depth_mm;
  probe.focus_mm = 30.0;
  probe.image_width_px = full.image_width_px;
  probe.image_height_px = full.image_height_px;
  probe.dynamic_range_db = 60.0;
  probe.gain_db = 20.0;
  probe.tgc_db_per_cm = 6.0;
  return probe;
}

inline double MeanGrey(const image::GrayImage& image) {
  double sum = 0.0;
  for (const std::uint8_t pixel : image.pixels) sum += pixel;
  return sum / static_cast<double>(image.pixels.size());
}

}  // namespace acus::testing_support
