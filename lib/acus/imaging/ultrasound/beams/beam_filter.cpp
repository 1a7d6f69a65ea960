#include "acus/imaging/ultrasound/beams/beam_filter.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/beams/beam_kernels.h"

namespace acus::ultrasound {
namespace {

constexpr int kMaxHalfAlong = 256;
constexpr int kMaxHalfAcross = slicing::BeamImage::kMargin;

/// Standard deviation of the Gaussian window whose autocorrelation is that of the interpolated
/// lattice, over the lattice's spacing (measured, averaged over directions).
constexpr double kSigmaOfGrain = 0.315;

/// The speckle's own grain makes up this much of the pulse's standard deviation.
constexpr double kGrainShare = 0.55;

/// exp(-t^2 / (2 sigma^2)), t = 0 ... half, up to `reach` standard deviations.
std::vector<double> HalfGauss(double sigma, double reach, int max_half) {
  std::vector<double> window{1.0};
  const int half = std::min(max_half, static_cast<int>(std::ceil(reach * sigma - 0.5)));
  for (int t = 1; t <= half; ++t) window.push_back(std::exp(-0.5 * t * t / (sigma * sigma)));
  return window;
}

double At(const std::vector<double>& half, int t) {
  const auto n = static_cast<std::size_t>(std::abs(t));
  return n < half.size() ? half[n] : 0.0;
}

/// Variance that a window leaves of noise with the autocorrelation of the grain.
double Variance(const std::vector<double>& half, double spacing, double grain_sigma) {
  const int n = static_cast<int>(half.size()) - 1;
  double sum = 0.0;
  for (int a = -n; a <= n; ++a) {
    for (int b = -n; b <= n; ++b) {
      const double apart = (a - b) * spacing / (2.0 * grain_sigma);
      sum += At(half, a) * At(half, b) * std::exp(-apart * apart);
    }
  }
  return sum;
}

double SumOfSquares(const std::vector<double>& half) {
  double sum = -1.0;
  for (const double value : half) sum += 2.0 * value * value;
  return sum;
}

void AppendTo(std::vector<float>& out, const std::vector<double>& values, double scale) {
  for (const double value : values) out.push_back(static_cast<float>(value * scale));
}

/// As fine as the pulse wants, but not so fine that samples fall between its points.
double GrainSigmaMm(const acoustics::Probe& probe, const acoustics::ScanGrid& grid) {
  const double sigma_mm = acoustics::SigmaOfFwhm(acoustics::AxialFwhmMm(probe));
  return std::clamp(kSigmaOfGrain * grid.step_mm, kGrainShare * sigma_mm, 0.95 * sigma_mm);
}

/// row[-margin ... -1] and beyond lines - 1: the row mirrored.
void MirrorMargins(float* row, int lines) {
  for (int t = 1; t <= slicing::BeamImage::kMargin; ++t) {
    row[-t] = row[std::min(t, lines - 1)];
    row[lines - 1 + t] = row[std::max(lines - 1 - t, 0)];
  }
}

}  // namespace

BeamFilter::BeamFilter(const acoustics::Probe& probe, const BeamOptions& options,
                       const acoustics::ScanGrid& grid)
    : grid_(grid),
      on_(options.point_spread),
      grain_mm_(GrainSigmaMm(probe, grid) / kSigmaOfGrain),
      grain_sigma_mm_(GrainSigmaMm(probe, grid)),
      look_(probe, grid, grain_sigma_mm_) {
  if (!on_) {
    along_ = spread_ = {1.0F};
    speckle_gain_.assign(static_cast<std::size_t>(grid.samples), 1.0F);
    noise_gain_ = speckle_gain_;
    across_over_along_.assign(static_cast<std::size_t>(grid.samples), 0.0);
    return;
  }
  MakeAxial(probe, options.point_spread_reach);
  MakeLateral(probe, options.point_spread_reach);
}

void BeamFilter::MakeAxial(const acoustics::Probe& probe, double reach) {
  const double sigma = acoustics::SigmaOfFwhm(acoustics::AxialFwhmMm(probe)) / grid_.step_mm;
  const double grain = grain_sigma_mm_ / grid_.step_mm;
  const double rest = std::sqrt(sigma * sigma - grain * grain);
  ACUS_REQUIRE(reach * std::max(rest, grain) <= kMaxHalfAlong, "probe: its pulse is longer than ",
               2 * kMaxHalfAlong, " samples of ", grid_.step_mm,
               " mm; give fewer samples_per_line, a greater depth or a higher frequency");
  const std::vector<double> along = HalfGauss(rest, reach, kMaxHalfAlong);
  const std::vector<double> spread = HalfGauss(grain, reach, kMaxHalfAlong);
  double peak = 0.0;
  for (int t = -kMaxHalfAlong; t <= kMaxHalfAlong; ++t) {
    peak += At(along, t) * At(spread, t);
    pulse_at_neighbour_ += At(along, t) * At(spread, t + 1);
  }
  pulse_at_neighbour_ /= peak;
  AppendTo(along_, along, 1.0);
  AppendTo(spread_, spread, 1.0 / peak);
  const double gain = 1.0 / std::sqrt(Variance(along, 1.0, grain));
  speckle_gain_.assign(static_cast<std::size_t>(grid_.samples), static_cast<float>(gain));
  noise_gain_.assign(static_cast<std::size_t>(grid_.samples),
                     static_cast<float>(1.0 / std::sqrt(SumOfSquares(along))));
}

BeamFilter::Shares BeamFilter::SharesAt(double fraction) const {
  if (pulse_at_neighbour_ <= 0.0) return {};
  // With p the pulse one sample away: nearest + p neighbour = 1, and p nearest + neighbour is the
  // Gaussian pulse there over that at the nearest sample, p^(1 - 2 |fraction|).
  const double p = pulse_at_neighbour_;
  const double there = std::pow(p, 1.0 - 2.0 * std::abs(fraction));
  const double neighbour = (there - p) / (1.0 - p * p);
  return {1.0 - p * neighbour, neighbour};
}

void BeamFilter::MakeLateral(const acoustics::Probe& probe, double reach) {
  for (int k = 0; k < grid_.samples; ++k) {
    const double spacing_mm = grid_.lines() > 1 ? grid_.LateralSpacingMm(k) : 1e9;
    const double sigma_mm =
        acoustics::SigmaOfFwhm(acoustics::LateralFwhmMm(probe, k * grid_.step_mm));
    // Half of the grain's share: between what points and what speckle should be filtered with.
    const double rest_mm =
        std::sqrt(std::max(0.0, sigma_mm * sigma_mm - 0.5 * grain_sigma_mm_ * grain_sigma_mm_));
    const double sigma = std::min(rest_mm / std::max(spacing_mm, 1e-6), kMaxHalfAcross / reach);
    const std::vector<double> across = HalfGauss(std::max(sigma, 1e-3), reach, kMaxHalfAcross);
    double sum = -1.0;
    for (const double value : across) sum += 2.0 * value;
    across_over_along_.push_back(sigma * spacing_mm /
                                 acoustics::SigmaOfFwhm(acoustics::AxialFwhmMm(probe)));
    across_half_.push_back(static_cast<int>(across.size()) - 1);
    across_at_.push_back(across_.size());
    AppendTo(across_, across, 1.0 / sum);
    const double variance = Variance(across, spacing_mm, grain_sigma_mm_) / (sum * sum);
    speckle_gain_[static_cast<std::size_t>(k)] /= static_cast<float>(std::sqrt(variance));
    noise_gain_[static_cast<std::size_t>(k)] *=
        static_cast<float>(sum / std::sqrt(SumOfSquares(across)));
  }
}

void BeamFilter::Apply(const ComplexBeams& in, int first, int last, float* scratch,
                       slicing::BeamImage& intensity) const {
  const int lines = in.re.lines();
  const int lanes = slicing::kernels::RoundUp(lines);
  const int half = static_cast<int>(along_.size()) - 1;
  std::array<const float*, 2 * kMaxHalfAlong + 1> rows;
  std::array<float*, 2> filtered{scratch + slicing::BeamImage::kMargin,
                                 scratch + in.re.stride() + slicing::BeamImage::kMargin};
  const std::array<const slicing::BeamImage*, 2> parts{&in.re, &in.im};
  for (int k = first; k < last; ++k) {
    const auto n = static_cast<std::size_t>(k);
    for (std::size_t part = 0; part < 2; ++part) {
      for (int t = -half; t <= half; ++t) {
        rows[static_cast<std::size_t>(half + t)] =
            parts[part]->row(std::clamp(k + t, 0, in.re.samples() - 1));
      }
      kernels::FilterAlongRow(rows.data(), along_.data(), half, lanes, filtered[part]);
      if (on_) MirrorMargins(filtered[part], lines);
    }
    const float unit = 1.0F;
    kernels::FilterAcrossRow(filtered[0], filtered[1], on_ ? &across_[across_at_[n]] : &unit,
                             on_ ? across_half_[n] : 0, lanes, intensity.row(k));
  }
}

}  // namespace acus::ultrasound
