#include "acus/imaging/ultrasound/display/display.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/imaging/slicing/kernels.h"

namespace acus::ultrasound {
namespace {

constexpr int kMaxHalfWindow = 128;

/// The lines of a phased probe start at one place: their distance in the middle counts.
double SpacingAtFaceMm(const acoustics::Probe& probe, const acoustics::ScanGrid& grid) {
  return grid.LateralSpacingMm(probe.kind == acoustics::ProbeKind::kPhased ? grid.samples / 2 : 0);
}

}  // namespace

std::vector<float> HalfHanning(double length_mm, double spacing_mm, int max_half) {
  std::vector<double> window{1.0};
  double sum = 1.0;
  for (int t = 1; t * spacing_mm < 0.5 * length_mm; ++t) {
    ACUS_REQUIRE(t <= max_half, "Hanning window: ", length_mm, " mm over steps of ", spacing_mm,
                 " mm is wider than ", 2 * max_half + 1,
                 " steps; give a shorter pulse or narrower beam, or a coarser image");
    window.push_back(0.5 * (1.0 + std::cos(2.0 * std::numbers::pi * t * spacing_mm / length_mm)));
    sum += 2.0 * window.back();
  }
  std::vector<float> out(window.size());
  for (std::size_t t = 0; t < out.size(); ++t) out[t] = static_cast<float>(window[t] / sum);
  return out;
}

double BrightnessOfGain(const acoustics::Probe& probe, std::optional<double> gain_of_table_db) {
  return (probe.gain_db - gain_of_table_db.value_or(probe.gain_db)) / probe.dynamic_range_db;
}

EchoDisplay::EchoDisplay(const acoustics::Probe& probe, const acoustics::ScanGrid& grid)
    : conversion_(probe, grid) {
  along_ = HalfHanning(probe.pulse_length_mm, grid.step_mm, kMaxHalfWindow);
  // A pulse gathers the echoes along its length: its peak is 1, so that the grey of an interface
  // depends neither on the pulse nor on how finely the beam is sampled.
  const float peak = along_[0];
  for (float& weight : along_) weight /= peak;
  const double lateral_mm = grid.lines() > 1 ? SpacingAtFaceMm(probe, grid) : 1e9;
  across_ = HalfHanning(probe.beam_width_mm, lateral_mm, slicing::BeamImage::kMargin);
  const double a = std::pow(10.0, probe.dynamic_range_db / 10.0);
  scale_ = static_cast<float>(255.0 / std::log2(1.0 + a));
  for (int k = 0; k < grid.samples; ++k) {
    const double gain_db = probe.gain_db + probe.tgc_db_per_cm * 0.1 * k * grid.step_mm;
    gain_.push_back(static_cast<float>(a * std::pow(10.0, gain_db / 10.0)));
  }
}

void EchoDisplay::CompressLine(const slicing::BeamImage& echo, int k, float* scratch,
                               std::uint8_t* grey) const {
  const int lanes = slicing::kernels::RoundUp(echo.lines());
  std::array<const float*, 2 * kMaxHalfWindow + 1> rows;
  const int half = static_cast<int>(along_.size()) - 1;
  for (int t = -half; t <= half; ++t) {
    rows[static_cast<std::size_t>(half + t)] = echo.row(std::clamp(k + t, 0, echo.samples() - 1));
  }
  float* along = scratch + slicing::BeamImage::kMargin;
  slicing::kernels::BlurAlongRow(rows.data(), along_.data(), half, lanes, along);
  const float* blurred = along;
  if (across_.size() > 1) {
    const int stride = echo.stride();
    std::fill(scratch, along, along[0]);
    std::fill(along + echo.lines(), scratch + stride, along[echo.lines() - 1]);
    float* across = scratch + stride + slicing::BeamImage::kMargin;
    slicing::kernels::BlurAcrossRow(along, across_.data(), static_cast<int>(across_.size()) - 1,
                                    lanes, across);
    blurred = across;
  }
  slicing::kernels::CompressRow(blurred, gain_[static_cast<std::size_t>(k)], scale_, lanes, grey);
}

void EchoDisplay::Show(const slicing::BeamImage& echo, image::GrayImage& out, int num_threads) {
  scratch_.Resize(echo.lines(), 2 * ScanConversion::Pieces(echo.samples()));
  const auto grey_row = [&](int k, int piece, std::uint8_t* grey) {
    CompressLine(echo, k, scratch_.padded_row(2 * piece), grey);
  };
  conversion_.Show(std::ref(grey_row), out, num_threads);
}

}  // namespace acus::ultrasound
