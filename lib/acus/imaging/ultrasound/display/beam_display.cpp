#include "acus/imaging/ultrasound/display/beam_display.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "acus/base/core/parallel.h"
#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/beams/beam_kernels.h"
#include "acus/imaging/ultrasound/display/grey_curve.h"

namespace acus::ultrasound {
namespace {

constexpr int kMaxWidthPx = 4096;
constexpr int kRowsPerPieceOfDisplay = 32;

int PiecesOfDisplay(int rows) {
  return (rows + kRowsPerPieceOfDisplay - 1) / kRowsPerPieceOfDisplay;
}

}  // namespace

BeamDisplay::BeamDisplay(const acoustics::Probe& probe, const acoustics::ScanGrid& grid,
                         const DisplayOptions& display, double tgc_limit_db)
    : grid_(grid),
      image_(acoustics::ImageOf(probe)),
      fan_(probe.kind != acoustics::ProbeKind::kLinear || probe.steer_rad != 0.0),
      has_curve_(display.curve != GreyCurve::kLog),
      curve_(GreyTable(display.curve, display.curve_parameter, probe.dynamic_range_db)),
      edges_(display.edge_strength, display.edge_sigma_mm, grid.step_mm),
      is_one_of_several_(display.compound_angles > 1) {
  // 10 log10(intensity) = 10 log10(2) log2(intensity).
  const double grey_per_db = 255.0 / probe.dynamic_range_db;
  scale_ = static_cast<float>(grey_per_db * 10.0 * std::log10(2.0));
  for (int k = 0; k < grid.samples; ++k) {
    const double depth_mm = k * grid.step_mm;
    double gain_db = probe.gain_db + std::min(probe.tgc_db_per_cm * 0.1 * depth_mm, tgc_limit_db);
    if (probe.second_harmonic)
      gain_db += 20.0 * std::log10(acoustics::HarmonicBuildUp(probe, depth_mm));
    offset_.push_back(static_cast<float>(255.0 + grey_per_db * gain_db));
  }
  stride_ = slicing::kernels::RoundUp(grid.lines());
  grey_.assign(
      static_cast<std::size_t>(stride_) * (static_cast<std::size_t>(grid.samples) + 2) + 16, 0);
  if (edges_.on()) enhanced_ = grey_;
  seen_.resize(static_cast<std::size_t>(image_.height_px));
  if (fan_) {
    MakeFan(probe);
  } else {
    MakeLinear();
  }
}

void BeamDisplay::MakeLinear() {
  const int lanes = slicing::kernels::RoundUp(image_.width_px);
  const double left_mm = grid_.start_mm.front().x();
  const double spacing_mm = grid_.lines() > 1 ? grid_.LateralSpacingMm(0) : 1.0;
  column_.assign(static_cast<std::size_t>(lanes) + slicing::kernels::kBlock, 0);
  column_fraction_.Reserve(static_cast<std::size_t>(lanes));
  int first = lanes;
  int last = 0;
  for (int c = 0; c < lanes; ++c) {
    const double x_mm = (c - 0.5 * (image_.width_px - 1)) * image_.lateral_mm_per_px;
    const double line = (x_mm - left_mm) / spacing_mm;
    const double low = std::clamp(std::floor(line), 0.0, std::max(0.0, grid_.lines() - 2.0));
    // The outermost lines are as wide as the others.
    const bool seen = c < image_.width_px && line >= -0.5 && line <= grid_.lines() - 0.5;
    column_[static_cast<std::size_t>(c)] = static_cast<std::int32_t>(low);
    column_fraction_.data()[c] = static_cast<float>(std::clamp(line - low, 0.0, 1.0));
    if (seen) {
      first = std::min(first, c);
      last = c + 1;
    }
  }
  for (int r = 0; r < image_.height_px; ++r) {
    const double sample = (image_.depth_of_top_row_mm + r * image_.axial_mm_per_px) / grid_.step_mm;
    const bool seen = sample >= -1e-6 && sample <= grid_.samples - 1 + 1e-6;
    const double low = std::clamp(std::floor(sample), 0.0, std::max(0.0, grid_.samples - 2.0));
    sample_.push_back(static_cast<std::int32_t>(low));
    sample_fraction_.push_back(static_cast<float>(std::clamp(sample - low, 0.0, 1.0)));
    if (seen && first < last) seen_[static_cast<std::size_t>(r)] = {first, last};
  }
}

void BeamDisplay::MakeFan(const acoustics::Probe& probe) {
  const int lanes = slicing::kernels::RoundUp(image_.width_px);
  const auto black = static_cast<std::int32_t>(grid_.samples) * stride_;
  at_.assign(static_cast<std::size_t>(lanes) * image_.height_px + slicing::kernels::kBlock, black);
  fractions_.assign(at_.size(), 0);
  const double line_rad = probe.field_of_view_rad / (grid_.lines() - 1);
  struct Place {
    double line;
    double sample;
  };
  const auto place = [&](double c, double r) {
    const double x = (c - 0.5 * (image_.width_px - 1)) * image_.lateral_mm_per_px;
    const double depth_mm = image_.depth_of_top_row_mm + r * image_.axial_mm_per_px;
    if (probe.steer_rad != 0.0) {
      const acoustics::BeamPlace at = acoustics::PlaceInBeams(probe, grid_, {x, depth_mm});
      return Place{at.line, at.sample};
    }
    const double y = depth_mm + probe.radius_mm;
    return Place{std::atan2(x, y) / line_rad + 0.5 * (grid_.lines() - 1),
                 (std::hypot(x, y) - probe.radius_mm) / grid_.step_mm};
  };
  edge_ = SectorEdge(image_.width_px, image_.height_px, [&](double c, double r) {
    const auto [line, sample] = place(c, r);
    return sample >= 0.0 && sample <= grid_.samples - 1 && line >= 0.0 && line <= grid_.lines() - 1;
  });
  for (int r = 0; r < image_.height_px; ++r) {
    Span span{lanes, 0};
    for (int c = 0; c < image_.width_px; ++c) {
      const int coverage = edge_.Coverage(r, c);
      if (coverage == 0 || (coverage < 256 && probe.steer_rad != 0.0)) continue;
      const Place at = place(c, r);
      const double line = std::clamp(at.line, 0.0, grid_.lines() - 1.0);
      const double sample = std::clamp(at.sample, 0.0, grid_.samples - 1.0);
      const double low_sample = std::min(std::floor(sample), grid_.samples - 2.0);
      const double low_line = std::min(std::floor(line), grid_.lines() - 2.0);
      const auto n = static_cast<std::size_t>(r) * lanes + c;
      at_[n] = static_cast<std::int32_t>(low_sample * stride_ + low_line);
      const auto part = [](double of) {
        return static_cast<unsigned>(std::min(255.0, std::floor(256.0 * of)));
      };
      fractions_[n] =
          static_cast<std::uint16_t>(part(line - low_line) + 256U * part(sample - low_sample));
      span.first = std::min(span.first, c);
      span.last = c + 1;
    }
    if (span.first < span.last) {
      seen_[static_cast<std::size_t>(r)] = {
          span.first / slicing::kernels::kBlock * slicing::kernels::kBlock,
          slicing::kernels::RoundUp(span.last)};
    }
  }
}

void BeamDisplay::Compress(const slicing::BeamImage& intensity, int first, int last) {
  for (int k = first; k < last; ++k) {
    kernels::GreyRow(intensity.row(k), offset_[static_cast<std::size_t>(k)], scale_,
                     slicing::kernels::RoundUp(grid_.lines()),
                     grey_.data() + static_cast<std::ptrdiff_t>(k) * stride_);
    if (!has_curve_) continue;
    std::uint8_t* row = grey_.data() + static_cast<std::ptrdiff_t>(k) * stride_;
    for (int l = 0; l < grid_.lines(); ++l) row[l] = curve_[row[l]];
  }
}

void BeamDisplay::Enhance(int num_threads) {
  if (!edges_.on()) return;
  ParallelFor(PiecesOfDisplay(grid_.samples), num_threads, [this](int piece) {
    const int first = piece * kRowsPerPieceOfDisplay;
    const int last = std::min(grid_.samples, first + kRowsPerPieceOfDisplay);
    for (int k = first; k < last; ++k) {
      edges_.EnhanceRow(grey_.data(), stride_, grid_.samples, k, grid_.lines(),
                        enhanced_.data() + static_cast<std::ptrdiff_t>(k) * stride_);
    }
  });
}

bool BeamDisplay::Covers(int row, int column) const {
  const auto r = static_cast<std::size_t>(row);
  if (!fan_) return column >= seen_[r].first && column < seen_[r].last;
  const int lanes = slicing::kernels::RoundUp(image_.width_px);
  const auto black = static_cast<std::int32_t>(grid_.samples) * stride_;
  return at_[r * static_cast<std::size_t>(lanes) + static_cast<std::size_t>(column)] != black;
}

void BeamDisplay::Show(image::GrayImage& out, int num_threads) {
  Enhance(num_threads);
  out.Resize(image_.width_px, image_.height_px);
  ParallelFor(PiecesOfDisplay(out.height), num_threads, [this, &out](int piece) {
    const int first = piece * kRowsPerPieceOfDisplay;
    Convert(first, std::min(out.height, first + kRowsPerPieceOfDisplay), out);
  });
}

void BeamDisplay::ConvertLinearRow(int r, std::uint8_t* out) const {
  const auto n = static_cast<std::size_t>(r);
  const std::uint8_t* upper = shown() + static_cast<std::ptrdiff_t>(sample_[n]) * stride_;
  const int first = seen_[n].first / slicing::kernels::kBlock * slicing::kernels::kBlock;
  kernels::ResampleColumnsRow({.upper = upper,
                               .lower = upper + stride_,
                               .column = column_.data() + first,
                               .across = column_fraction_.data() + first,
                               .along = sample_fraction_[n]},
                              slicing::kernels::RoundUp(seen_[n].last) - first, out + first);
}

void BeamDisplay::ConvertFanRow(int r, std::uint8_t* out) const {
  const auto& [first, last] = seen_[static_cast<std::size_t>(r)];
  const auto at =
      static_cast<std::ptrdiff_t>(r) * slicing::kernels::RoundUp(image_.width_px) + first;
  kernels::InterpolatePackedRow(shown(), stride_, at_.data() + at, fractions_.data() + at,
                                last - first, out + first);
  if (!is_one_of_several_) edge_.Blend(r, out);
}

void BeamDisplay::Convert(int first, int last, image::GrayImage& out) const {
  alignas(64) std::array<std::uint8_t, kMaxWidthPx + 2 * slicing::kernels::kBlock> row;
  for (int r = first; r < last; ++r) {
    std::uint8_t* pixels = out.pixels.data() + static_cast<std::ptrdiff_t>(r) * out.width;
    Span seen = seen_[static_cast<std::size_t>(r)];
    if (seen.first >= seen.last) {
      std::memset(pixels, 0, static_cast<std::size_t>(out.width));
      continue;
    }
    if (fan_) {
      ConvertFanRow(r, row.data());
    } else {
      ConvertLinearRow(r, row.data());
    }
    seen.last = std::min(seen.last, out.width);
    std::memset(pixels, 0, static_cast<std::size_t>(seen.first));
    std::memcpy(pixels + seen.first, row.data() + seen.first,
                static_cast<std::size_t>(seen.last - seen.first));
    std::memset(pixels + seen.last, 0, static_cast<std::size_t>(out.width - seen.last));
  }
}

}  // namespace acus::ultrasound
