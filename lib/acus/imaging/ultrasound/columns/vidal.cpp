#include "acus/imaging/ultrasound/columns/vidal.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "acus/base/core/error.h"
#include "acus/imaging/slicing/kernels.h"
#include "acus/imaging/slicing/needle_paint.h"
#include "acus/imaging/ultrasound/columns/echo.h"
#include "acus/imaging/ultrasound/display/coupling.h"
#include "acus/imaging/ultrasound/display/display.h"

namespace acus::ultrasound {
namespace {

void Check(const VidalOptions& o) {
  ACUS_REQUIRE(!o.noise || o.noise_grain_mm > 0.0, "noise/grain_mm: is ", o.noise_grain_mm,
               "; it must be above 0");
  ACUS_REQUIRE(o.noise_contrast >= 0.0 && o.noise_contrast <= 1.0, "noise/contrast: is ",
               o.noise_contrast, "; allowed is 0 to 1");
  ACUS_REQUIRE(o.needle_share >= 0.0 && o.needle_share <= 1.0, "shadow/needle_share: is ",
               o.needle_share, "; allowed is 0 to 1");
  ACUS_REQUIRE(o.surface_mm >= 0.0 && o.surface_mm < 1e3, "shadow/surface_mm: is ", o.surface_mm,
               "; it may not be negative");
  ACUS_REQUIRE(o.shadow_share >= 0.0 && o.shadow_share <= 1.0, "shadow/share: is ", o.shadow_share,
               "; allowed is 0 to 1");
  ACUS_REQUIRE(!o.reflections || (o.reflection_full_hu_per_mm > 0.0 && o.sobel_span_mm >= 0.0),
               "reflections: full_hu_per_mm ", o.reflection_full_hu_per_mm, " and span_mm ",
               o.sobel_span_mm, "; the first must be above 0, the second not below");
}

}  // namespace

VidalRenderer::VidalRenderer(const volume::CtVolume& ct, const acoustics::Probe& probe,
                             const VidalOptions& options)
    : probe_(acoustics::CheckedProbe(probe)),
      options_(options),
      grid_(acoustics::ScanGridOf(probe_)),
      sampler_(ct),
      conversion_(probe_, grid_),
      grey_(CurveOf(options.grey)),
      brightness_(options.brightness + BrightnessOfGain(probe_, options.gain_of_table_db)) {
  Check(options);
  surface_samples_ = static_cast<int>(std::lround(options.surface_mm / grid_.step_mm));
  if (options.noise) {
    noise_ = NoiseTile::White("noise volume", options.seed);
    for (int a = 0; a < 3; ++a) {
      tile_per_index_[a] = static_cast<float>(ct.geometry.spacing_mm[a] / options.noise_grain_mm);
    }
  }
  if (!options.reflections) return;
  const auto half_span = [&options](double spacing_mm, int limit) {
    return std::clamp(static_cast<int>(std::lround(0.5 * options.sobel_span_mm / spacing_mm)), 1,
                      limit);
  };
  sobel_samples_ = half_span(grid_.step_mm, grid_.samples);
  for (int k = 0; k < grid_.samples; ++k) {
    const double lateral_mm = grid_.lines() > 1 ? grid_.LateralSpacingMm(k) : 1.0;
    const int lines = half_span(lateral_mm, slicing::BeamImage::kMargin - 1);
    sobel_lines_.push_back(lines);
    per_mm_across_.push_back(static_cast<float>(1.0 / (8.0 * lines * lateral_mm)));
  }
}

void VidalRenderer::FindShadows() {
  const auto lanes = static_cast<std::size_t>(slicing::kernels::RoundUp(hu_.lines()));
  shadow_from_.assign(lanes, hu_.samples());
  needle_from_.assign(lanes, hu_.samples());
  if (!options_.shadow) return;
  const auto bone = static_cast<float>(options_.bone_above_hu);
  const auto gas = static_cast<float>(options_.gas_below_hu);
  int* from = shadow_from_.data();
  int* needle_from = needle_from_.data();
  for (int k = 0; k < hu_.samples(); ++k) {
    const float* hu = hu_.row(k);
    for (int l = 0; l < hu_.lines(); ++l) {
      const bool needle = hu[l] == slicing::kNeedleHu;
      const bool blocks = (hu[l] > bone || hu[l] < gas) && !needle;
      needle_from[l] = needle ? std::min(needle_from[l], k) : needle_from[l];
      from[l] = blocks ? std::min(from[l], k) : from[l];
    }
  }
}

void VidalRenderer::AddReflections(int k, int lanes, float* grey) const {
  const int a = std::max(0, k - sobel_samples_);
  const int b = std::min(hu_.samples() - 1, k + sobel_samples_);
  const int t = sobel_lines_[static_cast<std::size_t>(k)];
  const float* above = hu_.row(a);
  const float* here = hu_.row(k);
  const float* below = hu_.row(b);
  const auto along = static_cast<float>(1.0 / (4.0 * std::max(1, b - a) * grid_.step_mm));
  const float across = per_mm_across_[static_cast<std::size_t>(k)];
  const auto least = static_cast<float>(options_.reflection_min_hu_per_mm);
  const float brightest = static_cast<float>(options_.reflection_grey);
  const float per_slope =
      static_cast<float>(options_.reflection_grey / options_.reflection_full_hu_per_mm);
  const double cosine = std::cos(options_.reflection_max_angle_rad);
  const auto cosine_squared = static_cast<float>(cosine * cosine);
  for (int l = 0; l < lanes; ++l) {
    const float gy = along * ((below[l - t] + 2.0F * below[l] + below[l + t]) -
                              (above[l - t] + 2.0F * above[l] + above[l + t]));
    const float gx = across * ((above[l + t] + 2.0F * here[l + t] + below[l + t]) -
                               (above[l - t] + 2.0F * here[l - t] + below[l - t]));
    const float yy = gy * gy;
    const float slope = std::abs(gy);
    const bool reflects = slope > least && yy >= cosine_squared * (yy + gx * gx);
    grey[l] += reflects ? std::min(brightest, per_slope * slope) : 0.0F;
  }
}

void VidalRenderer::GreyRow(int k, int piece, std::uint8_t* grey) {
  const int lanes = slicing::kernels::RoundUp(hu_.lines());
  float* value = scratch_.row(2 * piece);
  slicing::kernels::CurveRow(grey_, hu_.row(k), lanes, value);
  if (noise_) {
    float* noise = scratch_.row(2 * piece + 1);
    for (int first = 0; first < lanes; first += slicing::BeamBend::kMaxLanes) {
      const int count = std::min(slicing::BeamBend::kMaxLanes, lanes - first);
      slicing::BeamBend::Row row;
      float sample = 0.0F;
      const slicing::kernels::Lines placed = bend_.PlaceRow(lines_, k, first, count, row, sample);
      noise_->Row(placed, sample, tile_per_index_, count, noise + first);
    }
    const auto contrast = static_cast<float>(options_.noise_contrast);
    for (int l = 0; l < lanes; ++l) value[l] *= 1.0F - contrast * (1.0F - noise[l]);
  }
  if (options_.reflections) AddReflections(k, lanes, value);
  if (options_.shadow) {
    const auto share = static_cast<float>(options_.shadow_share);
    const int* from = shadow_from_.data();
    const int behind = k - surface_samples_;
    const auto needle_share = static_cast<float>(options_.needle_share);
    const int* needle_from = needle_from_.data();
    for (int l = 0; l < lanes; ++l) {
      value[l] *= behind > from[l] ? share : (behind > needle_from[l] ? needle_share : 1.0F);
    }
  }
  slicing::kernels::WindowRow(value, static_cast<float>(255.0 * brightness_),
                              static_cast<float>(255.0 * options_.contrast), lanes, grey);
  scan_ends_.Clear(k, grey);
}

void VidalRenderer::Render(const Eigen::Isometry3d& ct_from_probe,
                           const std::optional<image::NeedleInImage>& needle, image::GrayImage& out,
                           int num_threads, const slicing::RestMap* rest) {
  sampler_.PlaceLines(grid_, ct_from_probe, lines_);
  bend_.Set(grid_, ct_from_probe, sampler_.index_from_ct(), rest);
  hu_.Resize(grid_.lines(), grid_.samples);
  sampler_.Sample(lines_, bend_, hu_, num_threads, slicing::CtSampler::kNotScanned);
  scan_ends_.FindAndFill(hu_);
  if (needle) slicing::PaintNeedle(*needle, ct_from_probe, probe_.slice_thickness_mm, grid_, hu_);
  FillCouplingGap(options_.coupling_gap_mm, grid_.step_mm, hu_);
  if (options_.reflections) {
    for (int k = 0; k < hu_.samples(); ++k) hu_.FillMargins(k);
  }
  FindShadows();
  scratch_.Resize(hu_.lines(), 2 * ScanConversion::Pieces(hu_.samples()));
  const auto grey_row = [this](int k, int piece, std::uint8_t* grey) { GreyRow(k, piece, grey); };
  conversion_.Show(std::ref(grey_row), out, num_threads);
}

}  // namespace acus::ultrasound
