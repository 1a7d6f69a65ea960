#include "acus/imaging/ultrasound/display/scan_conversion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "acus/base/core/parallel.h"
#include "acus/imaging/slicing/kernels.h"

namespace acus::ultrasound {

ScanConversion::ScanConversion(const acoustics::Probe& probe, const acoustics::ScanGrid& grid)
    : image_(acoustics::ImageOf(probe)),
      lines_(grid.lines()),
      samples_(grid.samples),
      step_mm_(grid.step_mm),
      fan_(probe.kind != acoustics::ProbeKind::kLinear) {
  if (fan_) PlacePixels(probe);
}

void ScanConversion::PlacePixels(const acoustics::Probe& probe) {
  grey_stride_ = slicing::kernels::RoundUp(lines_);
  // One row more than samples and a few bytes, so that neighbours at the end can be read.
  const auto rows = static_cast<std::size_t>(samples_) + 1;
  grey_.assign(static_cast<std::size_t>(grey_stride_) * rows + 16, 0);
  const int lanes = slicing::kernels::RoundUp(image_.width_px);
  const auto count = static_cast<std::size_t>(lanes) * image_.height_px;
  across_fraction_.Reserve(count);
  along_fraction_.Reserve(count);
  offset_storage_.Reserve(count);
  offset_ = reinterpret_cast<std::int32_t*>(offset_storage_.data());
  const double line_rad = probe.field_of_view_rad / (lines_ - 1);
  struct Place {
    double line;
    double sample;
  };
  const auto place = [&](double c, double r) {
    const double x = (c - 0.5 * (image_.width_px - 1)) * image_.lateral_mm_per_px;
    const double y = image_.depth_of_top_row_mm + r * image_.axial_mm_per_px + probe.radius_mm;
    return Place{std::atan2(x, y) / line_rad + 0.5 * (lines_ - 1),
                 (std::hypot(x, y) - probe.radius_mm) / step_mm_};
  };
  edge_ = SectorEdge(image_.width_px, image_.height_px, [&](double c, double r) {
    const auto [line, sample] = place(c, r);
    return sample >= 0.0 && sample <= samples_ - 1 && line >= 0.0 && line <= lines_ - 1;
  });
  std::size_t n = 0;
  for (int r = 0; r < image_.height_px; ++r) {
    for (int c = 0; c < lanes; ++c, ++n) {
      const bool seen = c < image_.width_px && edge_.Coverage(r, c) > 0;
      const Place at = place(c, r);
      const double line = std::clamp(at.line, 0.0, lines_ - 1.0);
      const double sample = std::clamp(at.sample, 0.0, samples_ - 1.0);
      const double low_sample = std::min(std::floor(sample), samples_ - 2.0);
      const double low_line = std::min(std::floor(line), lines_ - 2.0);
      offset_[n] = seen ? static_cast<std::int32_t>(low_sample * grey_stride_ + low_line) : -1;
      along_fraction_.data()[n] = seen ? static_cast<float>(sample - low_sample) : 0.0F;
      across_fraction_.data()[n] = seen ? static_cast<float>(line - low_line) : 0.0F;
    }
  }
}

void ScanConversion::Show(const GreyRow& grey_row, image::GrayImage& out, int num_threads) {
  out.Resize(image_.width_px, image_.height_px);
  if (fan_) {
    ShowFan(grey_row, out, num_threads);
  } else {
    ShowLinear(grey_row, out, num_threads);
  }
}

void ScanConversion::ShowLinear(const GreyRow& grey_row, image::GrayImage& out, int num_threads) {
  const int lanes = slicing::kernels::RoundUp(lines_);
  grey_.resize(static_cast<std::size_t>(lanes) * Pieces(samples_));
  const int left = (out.width - lines_) / 2;
  const int above = acoustics::RowsAboveFace(image_);
  std::fill_n(out.pixels.begin(), static_cast<std::ptrdiff_t>(above) * out.width, std::uint8_t{0});
  const auto piece = [&](int p) {
    std::uint8_t* grey = grey_.data() + static_cast<std::ptrdiff_t>(p) * lanes;
    const int end = std::min(samples_, (p + 1) * kRowsPerPiece);
    for (int k = p * kRowsPerPiece; k < end; ++k) {
      grey_row(k, p, grey);
      std::uint8_t* row = out.pixels.data() + static_cast<std::ptrdiff_t>(above + k) * out.width;
      std::memset(row, 0, static_cast<std::size_t>(left));
      std::memcpy(row + left, grey, static_cast<std::size_t>(lines_));
      std::memset(row + left + lines_, 0, static_cast<std::size_t>(out.width - left - lines_));
    }
  };
  ParallelFor(Pieces(samples_), num_threads, std::ref(piece));
  std::fill(out.pixels.begin() + static_cast<std::ptrdiff_t>(above + samples_) * out.width,
            out.pixels.end(), std::uint8_t{0});
}

void ScanConversion::ShowFan(const GreyRow& grey_row, image::GrayImage& out, int num_threads) {
  const auto compute = [&](int p) {
    const int end = std::min(samples_, (p + 1) * kRowsPerPiece);
    for (int k = p * kRowsPerPiece; k < end; ++k) {
      grey_row(k, p, grey_.data() + static_cast<std::ptrdiff_t>(k) * grey_stride_);
    }
  };
  ParallelFor(Pieces(samples_), num_threads, std::ref(compute));
  const int lanes = slicing::kernels::RoundUp(out.width);
  const auto convert = [&](int p) {
    std::array<std::uint8_t, 4096 + slicing::kernels::kBlock> row;
    const int end = std::min(out.height, (p + 1) * kRowsPerPiece);
    for (int r = p * kRowsPerPiece; r < end; ++r) {
      const auto first = static_cast<std::ptrdiff_t>(r) * lanes;
      slicing::kernels::InterpolateRow(grey_.data(), grey_stride_, offset_ + first,
                                       across_fraction_.data() + first,
                                       along_fraction_.data() + first, lanes, row.data());
      edge_.Blend(r, row.data());
      std::memcpy(out.pixels.data() + static_cast<std::ptrdiff_t>(r) * out.width, row.data(),
                  static_cast<std::size_t>(out.width));
    }
  };
  ParallelFor(Pieces(out.height), num_threads, std::ref(convert));
}

}  // namespace acus::ultrasound
