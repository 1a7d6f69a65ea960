#include "acus/imaging/slicing/slab.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/imaging/slicing/kernels.h"
#include "acus/imaging/slicing/needle_paint.h"

namespace acus::slicing {
namespace {

constexpr double kLargestMm = 200.0;
/// Thickness of a single slice in which the needle is drawn.
constexpr double kThinMm = 2.0;

}  // namespace

SlabRenderer::SlabRenderer(const volume::CtVolume& ct, const image::ImageGeometry& geometry,
                           const SlabSettings& settings)
    : sampler_(ct), geometry_(geometry), settings_(settings) {
  const HuWindow& window = settings.window;
  ACUS_REQUIRE(window.width_hu > 0.0 && std::isfinite(window.width_hu + window.centre_hu),
               "slab: the window is ", window.width_hu, " HU wide; it must be above 0");
  ACUS_REQUIRE(settings.thickness_mm >= 0.0 && settings.thickness_mm <= kLargestMm,
               "slab: a thickness of ", settings.thickness_mm, " mm; allowed is 0 to ", kLargestMm,
               " mm");
  grid_ = acoustics::ScanGridOf(geometry);
  const double spacing_mm = ct.geometry.spacing_mm.minCoeff();
  num_slices_ = std::max(1, static_cast<int>(std::ceil(settings.thickness_mm / spacing_mm - 1e-9)));
}

/// The slice that was sampled to those before it.
void SlabRenderer::Add(int slice) {
  if (slice == 0) {
    std::swap(sum_, slice_);
    return;
  }
  const auto share = 1.0F / static_cast<float>(slice + 1);
  for (int r = 0; r < sum_.samples(); ++r) {
    float* sum = sum_.row(r);
    const float* value = slice_.row(r);
    if (settings_.value == SlabValue::kMean) {
      for (int c = 0; c < sum_.lines(); ++c) sum[c] += share * (value[c] - sum[c]);
    } else {
      for (int c = 0; c < sum_.lines(); ++c) sum[c] = std::max(sum[c], value[c]);
    }
  }
}

void SlabRenderer::Render(const Eigen::Isometry3d& ct_from_plane,
                          const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
                          int num_threads, const RestMap* rest) {
  double rest_at_mm = 0.0;
  for (int n = 0; n < num_slices_; ++n) {
    const double at_mm = settings_.thickness_mm * ((n + 0.5) / num_slices_ - 0.5);
    const Eigen::Isometry3d slice = ct_from_plane * Eigen::Translation3d(0.0, 0.0, at_mm);
    sampler_.PlaceLines(grid_, slice, lines_);
    if (n == 0 || (rest != nullptr && at_mm - rest_at_mm > kSameRestMm)) {
      bend_.Set(grid_, slice, sampler_.index_from_ct(), rest);
      rest_at_mm = at_mm;
    }
    slice_.Resize(grid_.lines(), grid_.samples);
    sampler_.Sample(lines_, bend_, slice_, num_threads);
    Add(n);
  }
  if (needle) {
    PaintNeedle(*needle, ct_from_plane, std::max(kThinMm, settings_.thickness_mm), grid_, sum_);
  }
  out.Resize(geometry_.width_px, geometry_.height_px);
  const HuWindow& window = settings_.window;
  const double scale = 255.0 / window.width_hu;
  const double offset = 127.5 - window.centre_hu * scale;
  for (int r = 0; r < out.height; ++r) {
    for (int c = 0; c < out.width; ++c) {
      const double grey = offset + scale * static_cast<double>(sum_.row(r)[c]);
      out.pixels[static_cast<std::size_t>(r) * static_cast<std::size_t>(out.width) +
                 static_cast<std::size_t>(c)] =
          static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, 255.0)));
    }
  }
}

}  // namespace acus::slicing
