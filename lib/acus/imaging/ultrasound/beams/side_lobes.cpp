#include "acus/imaging/ultrasound/beams/side_lobes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/imaging/acoustics/beam_width.h"
#include "acus/imaging/ultrasound/beams/beam_interface.h"

namespace acus::ultrasound {
namespace {

constexpr double kStepMm = 5.0;
/// In standard deviations of the point spread: beyond begin the lobes.
constexpr double kMainLobe = 2.6;
/// Pairs of lines: what a reflector adds to them is kept for each pair.
constexpr int kMostBins = 96;
constexpr int kSines = 1024;  ///< Of a table over 0 to 2.

double WeightOf(Apodisation apodisation, double place) {
  const double angle = std::numbers::pi * place;  // place: -1/2 to 1/2
  switch (apodisation) {
    case Apodisation::kCosine:
      return std::cos(angle);
    case Apodisation::kHann:
      return std::cos(angle) * std::cos(angle);
    case Apodisation::kRectangular:
      break;
  }
  return 1.0;
}

double PitchMm(const acoustics::Probe& probe) {
  return probe.pitch_mm > 0.0 ? probe.pitch_mm : probe.ArrayLengthMm() / probe.elements;
}

int ElementsOf(const acoustics::Probe& probe, double aperture_mm) {
  return std::clamp(static_cast<int>(std::lround(aperture_mm / PitchMm(probe))), 1, probe.elements);
}

/// LobeIntensity over sine, 0 to 2.
std::vector<double> LobeTable(const acoustics::Probe& probe, Apodisation apodisation,
                              double depth_mm) {
  std::vector<double> table;
  for (int n = 0; n <= kSines; ++n) {
    table.push_back(LobeIntensity(probe, apodisation, depth_mm, 2.0 * n / kSines));
  }
  return table;
}

/// What a line sees of a reflector beside it.
struct View {
  double range_mm = 0.0;
  double sine = 0.0;  ///< From the line.
  double beside_mm = 0.0;
  double directivity = 1.0;  ///< Amplitude, two-way, and of the mirror's lobe.
};

View ViewOf(const acoustics::Probe& probe, const acoustics::ScanGrid& rows, double from, double to,
            double depth_mm, double lobe_deg, double diffuse_share) {
  const double apart = from - to;
  View view;
  if (probe.kind == acoustics::ProbeKind::kPhased) {
    const double line_rad = probe.field_of_view_rad / (rows.lines() - 1);
    const double middle = 0.5 * (rows.lines() - 1);
    view.range_mm = depth_mm;
    view.sine = std::sin((from - middle) * line_rad) - std::sin((to - middle) * line_rad);
    view.beside_mm = depth_mm * apart * line_rad;
    return view;
  }
  if (probe.kind == acoustics::ProbeKind::kLinear) {
    view.beside_mm = apart * rows.LateralSpacingMm(0);
    view.range_mm = std::hypot(depth_mm, view.beside_mm);
    view.sine = view.beside_mm / std::max(view.range_mm, 1e-6);
  } else {
    const double angle = apart * probe.field_of_view_rad / (rows.lines() - 1);
    const double deep_mm = probe.radius_mm + depth_mm;
    view.beside_mm = deep_mm * angle;
    view.range_mm = std::sqrt(std::max(0.0, probe.radius_mm * probe.radius_mm + deep_mm * deep_mm -
                                                2.0 * probe.radius_mm * deep_mm * std::cos(angle)));
    view.sine = deep_mm * std::sin(angle) / std::max(view.range_mm, 1e-6);
  }
  const double sine = std::clamp(view.sine, -1.0, 1.0);
  const double width = SideLobes::kElementShare * PitchMm(probe) / acoustics::WavelengthMm(probe);
  const double element = ElementDirectivity(width, sine);
  const double received = probe.second_harmonic ? ElementDirectivity(2.0 * width, sine) : 1.0;
  view.directivity = element * element * received *
                     MirrorLobe(std::sqrt(1.0 - sine * sine), lobe_deg, diffuse_share);
  return view;
}

}  // namespace

double ArrayEnergy(double pitch_over_wavelength, int elements, double sine,
                   double fractional_bandwidth, Apodisation apodisation) {
  std::vector<double> weight;
  double whole = 0.0;
  for (int n = 0; n < elements; ++n) {
    weight.push_back(WeightOf(apodisation, (n + 0.5) / elements - 0.5));
    whole += weight.back();
  }
  const double phase = 2.0 * std::numbers::pi * pitch_over_wavelength * sine;
  // Standard deviation of the energy's spectrum over sqrt(2) f0, from the two-way FWHM.
  const double band = acoustics::SigmaOfFwhm(fractional_bandwidth) / std::numbers::sqrt2;
  double sum = 0.0;
  for (int lag = 0; lag < elements; ++lag) {
    const double spread = band * phase * lag;
    const double pulse = std::exp(-spread * spread);
    if (pulse < 1e-9) break;
    double both = 0.0;
    for (int n = 0; n + lag < elements; ++n) {
      both += weight[static_cast<std::size_t>(n)] * weight[static_cast<std::size_t>(n + lag)];
    }
    sum += (lag == 0 ? 1.0 : 2.0) * both * pulse * std::cos(phase * lag);
  }
  return std::max(0.0, sum) / (whole * whole);
}

double ElementDirectivity(double width_over_wavelength, double sine) {
  const double x = std::numbers::pi * width_over_wavelength * sine;
  const double sinc = std::abs(x) < 1e-6 ? 1.0 : std::sin(x) / x;
  return sinc * std::sqrt(std::max(0.0, 1.0 - sine * sine));
}

double LobeIntensity(const acoustics::Probe& probe, Apodisation apodisation, double depth_mm,
                     double sine) {
  const double pitch = PitchMm(probe) / acoustics::WavelengthMm(probe);
  const auto energy = [&](double aperture_mm, double harmonic) {
    return ArrayEnergy(harmonic * pitch, ElementsOf(probe, aperture_mm), sine,
                       probe.fractional_bandwidth / harmonic, apodisation);
  };
  const double sent = energy(acoustics::TransmitApertureMm(probe), 1.0);
  const double receive_mm = acoustics::ReceiveApertureMm(probe, depth_mm);
  // The second harmonic goes with the square of the pressure that is sent.
  return probe.second_harmonic ? sent * sent * energy(receive_mm, 2.0)
                               : sent * energy(receive_mm, 1.0);
}

SideLobes::SideLobes(const acoustics::Probe& probe, const acoustics::ScanGrid& rows,
                     Apodisation apodisation, double lobe_deg, double diffuse_share)
    : rows_(rows),
      lines_per_bin_(std::max(4, rows.lines() / kMostBins)),
      bins_((rows.lines() + lines_per_bin_ - 1) / lines_per_bin_),
      rows_per_step_(std::max(1, static_cast<int>(kStepMm / rows.step_mm))),
      steps_((rows.samples - 1) / rows_per_step_ + 1) {
  ghosts_.resize(static_cast<std::size_t>(steps_) * static_cast<std::size_t>(bins_) *
                 static_cast<std::size_t>(bins_));
  MakeGhosts(probe, apodisation, lobe_deg, diffuse_share);
  sums_.resize(static_cast<std::size_t>(bins_) * static_cast<std::size_t>(rows.samples + 1));
  added_.Resize(rows.lines(), rows.samples);
}

double SideLobes::LineOfBin(int bin) const {
  return bin * lines_per_bin_ + 0.5 * (lines_per_bin_ - 1);
}

void SideLobes::MakeGhosts(const acoustics::Probe& probe, Apodisation apodisation, double lobe_deg,
                           double diffuse_share) {
  const double pulse_mm =
      acoustics::SigmaOfFwhm(acoustics::AxialFwhmMm(probe)) * std::sqrt(std::numbers::pi);
  Ghost* ghost = ghosts_.data();
  for (int step = 0; step < steps_; ++step) {
    const double depth_mm =
        std::max(0.5, static_cast<double>(step)) * rows_per_step_ * rows_.step_mm;
    const int row = static_cast<int>(depth_mm / rows_.step_mm);
    const double sigma_mm = acoustics::SigmaOfFwhm(acoustics::LateralFwhmMm(probe, depth_mm));
    const std::vector<double> table = LobeTable(probe, apodisation, depth_mm);
    const double aperture_mm = 0.5 * (acoustics::TransmitApertureMm(probe) +
                                      acoustics::ReceiveApertureMm(probe, depth_mm));
    const double bin_mm = lines_per_bin_ * rows_.LateralSpacingMm(std::min(row, rows_.samples - 1));
    cells_.push_back(static_cast<float>(bin_mm / (sigma_mm * std::sqrt(2.0 * std::numbers::pi))));
    for (int from = 0; from < bins_; ++from) {
      for (int to = 0; to < bins_; ++to, ++ghost) {
        const View view =
            ViewOf(probe, rows_, LineOfBin(from), LineOfBin(to), depth_mm, lobe_deg, diffuse_share);
        if (std::abs(view.beside_mm) < kMainLobe * sigma_mm + 0.5 * bin_mm) continue;
        const auto n = static_cast<std::size_t>(
            std::min(std::abs(view.sine) * 0.5 * kSines, static_cast<double>(kSines)));
        const double intensity = table[n] * view.directivity * view.directivity;
        if (intensity < kFaintest) continue;
        // The aperture's elements hear it one after the other.
        const double long_mm = aperture_mm * std::abs(view.sine);
        ghost->level = static_cast<float>(intensity * pulse_mm / (pulse_mm + long_mm));
        const double first = (view.range_mm - 0.5 * long_mm) / rows_.step_mm - row;
        ghost->first = static_cast<std::int16_t>(std::lround(first));
        ghost->count = static_cast<std::int16_t>(1 + std::lround(long_mm / rows_.step_mm));
        any_ = true;
      }
    }
  }
}

void SideLobes::Spread(const slicing::BeamImage& echoes) {
  if (!any_) return;
  std::fill(sums_.begin(), sums_.end(), 0.0F);
  const auto bins = static_cast<std::size_t>(bins_);
  for (int k = 0; k < rows_.samples; ++k) {
    const auto step =
        static_cast<std::size_t>(std::min((k + rows_per_step_ / 2) / rows_per_step_, steps_ - 1));
    const float* row = echoes.row(k);
    for (std::size_t from = 0; from < bins; ++from) {
      const int first = static_cast<int>(from) * lines_per_bin_;
      const int end = std::min(first + lines_per_bin_, rows_.lines());
      float sum = 0.0F;
      for (int l = first; l < end; ++l) sum += row[l];
      if (sum <= 0.0F) continue;
      const float source = sum / static_cast<float>(lines_per_bin_) * cells_[step];
      const Ghost* ghost = ghosts_.data() + (step * bins + from) * bins;
      for (std::size_t to = 0; to < bins; ++to, ++ghost) {
        if (ghost->level == 0.0F) continue;
        const int low = std::clamp(k + ghost->first, 0, rows_.samples);
        const int high = std::clamp(k + ghost->first + ghost->count, 0, rows_.samples);
        sums_[static_cast<std::size_t>(low) * bins + to] += source * ghost->level;
        sums_[static_cast<std::size_t>(high) * bins + to] -= source * ghost->level;
      }
    }
  }
  for (int k = 0; k < rows_.samples; ++k) {
    float* sum = sums_.data() + static_cast<std::size_t>(k) * bins;
    for (std::size_t b = 0; k > 0 && b < bins; ++b) sum[b] += sum[b - bins];
    float* out = added_.row(k);
    for (int l = 0; l < rows_.lines(); ++l) {
      const double at = std::clamp((l - LineOfBin(0)) / lines_per_bin_, 0.0, bins_ - 1.0);
      const auto low = static_cast<std::size_t>(at);
      const auto share = static_cast<float>(at - static_cast<double>(low));
      const float next = sum[std::min(low + 1, bins - 1)];
      out[l] = std::max(0.0F, sum[low] + share * (next - sum[low]));
    }
  }
}

}  // namespace acus::ultrasound
