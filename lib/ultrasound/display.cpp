#include "ultrasound/display.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>

#include "core/error.h"
#include "core/parallel.h"
#include "ultrasound/kernels.h"

namespace acus::ultrasound {
namespace {

constexpr int kRowsPerPiece = 64;
constexpr int kMaxHalfAlong = 128;

int Pieces(int rows) {
  return (rows + kRowsPerPiece - 1) / kRowsPerPiece;
}

}  // namespace

std::vector<float> HalfHanning(double length_mm, double spacing_mm, int max_half) {
  std::vector<double> window{1.0};
  double sum = 1.0;
  for (int t = 1; t * spacing_mm < 0.5 * length_mm; ++t) {
    ACUS_REQUIRE(t <= max_half, "Hanning window: ", length_mm, " mm over steps of ", spacing_mm,
                 " mm is wider than ", 2 * max_half + 1,
                 " steps; give a shorter pulse or narrower beam, or a coarser picture");
    window.push_back(0.5 * (1.0 + std::cos(2.0 * std::numbers::pi * t * spacing_mm / length_mm)));
    sum += 2.0 * window.back();
  }
  std::vector<float> out(window.size());
  for (std::size_t t = 0; t < out.size(); ++t) out[t] = static_cast<float>(window[t] / sum);
  return out;
}

EchoDisplay::EchoDisplay(const Probe& probe, const ScanGrid& grid)
    : probe_(probe), grid_(grid), picture_(PictureOf(probe)) {
  along_ = HalfHanning(probe.pulse_length_mm, grid.step_mm, kMaxHalfAlong);
  // A pulse gathers the echoes along its length: its peak is 1, so that the grey of an interface
  // depends neither on the pulse nor on how finely the beam is sampled.
  const float peak = along_[0];
  for (float& weight : along_) weight /= peak;
  const double lateral_mm = grid.lines() > 1 ? grid.LateralSpacingMm(0) : 1e9;
  across_ = HalfHanning(probe.beam_width_mm, lateral_mm, BeamImage::kMargin);
  const double a = std::pow(10.0, probe.dynamic_range_db / 10.0);
  scale_ = static_cast<float>(255.0 / std::log2(1.0 + a));
  for (int k = 0; k < grid.samples; ++k) {
    const double gain_db = probe.gain_db + probe.tgc_db_per_cm * 0.1 * k * grid.step_mm;
    gain_.push_back(static_cast<float>(a * std::pow(10.0, gain_db / 10.0)));
  }
  if (probe.kind == ProbeKind::kCurvilinear) MakeScanConversion();
}

void EchoDisplay::MakeScanConversion() {
  grey_stride_ = kernels::RoundUp(grid_.lines());
  // One row more than samples and a few bytes, so that neighbours at the end can be read.
  const auto rows = static_cast<std::size_t>(grid_.samples) + 1;
  grey_.assign(static_cast<std::size_t>(grey_stride_) * rows + 16, 0);
  const int lanes = kernels::RoundUp(picture_.width_px);
  const auto count = static_cast<std::size_t>(lanes) * picture_.height_px;
  across_fraction_.Reserve(count);
  along_fraction_.Reserve(count);
  offset_storage_.Reserve(count);
  offset_ = reinterpret_cast<std::int32_t*>(offset_storage_.data());
  const double line_rad = probe_.field_of_view_rad / (grid_.lines() - 1);
  std::size_t n = 0;
  for (int r = 0; r < picture_.height_px; ++r) {
    for (int c = 0; c < lanes; ++c, ++n) {
      const double x = (c - 0.5 * (picture_.width_px - 1)) * picture_.lateral_mm_per_px;
      const double y =
          picture_.depth_of_top_row_mm + r * picture_.axial_mm_per_px + probe_.radius_mm;
      const double sample = (std::hypot(x, y) - probe_.radius_mm) / grid_.step_mm;
      const double line = std::atan2(x, y) / line_rad + 0.5 * (grid_.lines() - 1);
      const bool seen = c < picture_.width_px && sample >= 0.0 && sample <= grid_.samples - 1 &&
                        line >= 0.0 && line <= grid_.lines() - 1;
      const double low_sample = std::min(std::floor(sample), grid_.samples - 2.0);
      const double low_line = std::min(std::floor(line), grid_.lines() - 2.0);
      offset_[n] = seen ? static_cast<std::int32_t>(low_sample * grey_stride_ + low_line) : -1;
      along_fraction_.data()[n] = seen ? static_cast<float>(sample - low_sample) : 0.0F;
      across_fraction_.data()[n] = seen ? static_cast<float>(line - low_line) : 0.0F;
    }
  }
}

void EchoDisplay::CompressLine(const BeamImage& echo, int k, float* scratch,
                               std::uint8_t* grey) const {
  const int lanes = kernels::RoundUp(echo.lines());
  std::array<const float*, 2 * kMaxHalfAlong + 1> rows;
  const int half = static_cast<int>(along_.size()) - 1;
  for (int t = -half; t <= half; ++t) {
    rows[static_cast<std::size_t>(half + t)] = echo.row(std::clamp(k + t, 0, echo.samples() - 1));
  }
  float* along = scratch + BeamImage::kMargin;
  kernels::BlurAlongRow(rows.data(), along_.data(), half, lanes, along);
  const float* blurred = along;
  if (across_.size() > 1) {
    const int stride = echo.stride();
    std::fill(scratch, along, along[0]);
    std::fill(along + echo.lines(), scratch + stride, along[echo.lines() - 1]);
    float* across = scratch + stride + BeamImage::kMargin;
    kernels::BlurAcrossRow(along, across_.data(), static_cast<int>(across_.size()) - 1, lanes,
                           across);
    blurred = across;
  }
  kernels::CompressRow(blurred, gain_[static_cast<std::size_t>(k)], scale_, lanes, grey);
}

void EchoDisplay::Show(const BeamImage& echo, GrayImage& out, int num_threads) {
  out.Resize(picture_.width_px, picture_.height_px);
  scratch_.Resize(echo.lines(), 2 * Pieces(echo.samples()));
  if (probe_.kind == ProbeKind::kLinear) {
    ShowLinear(echo, out, num_threads);
  } else {
    ShowFan(echo, out, num_threads);
  }
}

void EchoDisplay::ShowLinear(const BeamImage& echo, GrayImage& out, int num_threads) {
  const int lanes = kernels::RoundUp(echo.lines());
  grey_.resize(static_cast<std::size_t>(lanes) * Pieces(echo.samples()));
  const int left = (out.width - echo.lines()) / 2;
  const auto piece = [&](int p) {
    float* scratch = scratch_.padded_row(2 * p);
    std::uint8_t* grey = grey_.data() + static_cast<std::ptrdiff_t>(p) * lanes;
    const int end = std::min(echo.samples(), (p + 1) * kRowsPerPiece);
    for (int k = p * kRowsPerPiece; k < end; ++k) {
      CompressLine(echo, k, scratch, grey);
      std::uint8_t* row = out.pixels.data() + static_cast<std::ptrdiff_t>(k) * out.width;
      std::memset(row, 0, static_cast<std::size_t>(left));
      std::memcpy(row + left, grey, static_cast<std::size_t>(echo.lines()));
      std::memset(row + left + echo.lines(), 0,
                  static_cast<std::size_t>(out.width - left - echo.lines()));
    }
  };
  ParallelFor(Pieces(echo.samples()), num_threads, std::ref(piece));
  std::fill(out.pixels.begin() + static_cast<std::ptrdiff_t>(echo.samples()) * out.width,
            out.pixels.end(), std::uint8_t{0});
}

void EchoDisplay::ShowFan(const BeamImage& echo, GrayImage& out, int num_threads) {
  const auto compress = [&](int p) {
    const int end = std::min(echo.samples(), (p + 1) * kRowsPerPiece);
    for (int k = p * kRowsPerPiece; k < end; ++k) {
      CompressLine(echo, k, scratch_.padded_row(2 * p),
                   grey_.data() + static_cast<std::ptrdiff_t>(k) * grey_stride_);
    }
  };
  ParallelFor(Pieces(echo.samples()), num_threads, std::ref(compress));
  const int lanes = kernels::RoundUp(out.width);
  const auto convert = [&](int p) {
    std::array<std::uint8_t, 4096 + kernels::kBlock> row;
    const int end = std::min(out.height, (p + 1) * kRowsPerPiece);
    for (int r = p * kRowsPerPiece; r < end; ++r) {
      const auto first = static_cast<std::ptrdiff_t>(r) * lanes;
      kernels::InterpolateRow(grey_.data(), grey_stride_, offset_ + first,
                              across_fraction_.data() + first, along_fraction_.data() + first,
                              lanes, row.data());
      std::memcpy(out.pixels.data() + static_cast<std::ptrdiff_t>(r) * out.width, row.data(),
                  static_cast<std::size_t>(out.width));
    }
  };
  ParallelFor(Pieces(out.height), num_threads, std::ref(convert));
}

}  // namespace acus::ultrasound
