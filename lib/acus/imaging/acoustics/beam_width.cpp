#include "acus/imaging/acoustics/beam_width.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::acoustics {
namespace {

/// Width over lambda F at which sinc(x) = 1/2, twice x = 0.60335.
constexpr double kSincFwhm = 1.2067;
/// FWHM of exp(-x^2 / w^2) over w: 2 sqrt(ln 2).
constexpr double kGaussFwhm = 1.6651092;
/// 1/e radius over aperture of the Gaussian beam that is as wide in the focus.
constexpr double kRadiusOfAperture = kGaussFwhm / (std::numbers::pi * kSincFwhm);

double FocusMm(const Probe& probe) {
  return probe.focus_mm > 0.0 ? probe.focus_mm : 0.5 * probe.depth_mm;
}

double FullApertureMm(const Probe& probe) {
  return probe.pitch_mm > 0.0 ? probe.pitch_mm * probe.elements : probe.ArrayLengthMm();
}

/// The product of two Gaussians.
double ProductFwhm(double a, double b) {
  return 1.0 / std::sqrt(1.0 / (a * a) + 1.0 / (b * b));
}

}  // namespace

double WavelengthMm(const Probe& probe, double speed_m_per_s) {
  return 1e-3 * speed_m_per_s / probe.frequency_mhz;
}

double ReceivedMhz(const Probe& probe) {
  return probe.second_harmonic ? 2.0 * probe.frequency_mhz : probe.frequency_mhz;
}

double HarmonicBuildUp(const Probe& probe, double depth_mm) {
  // Next to the face a few waves are enough to be above nothing.
  constexpr double kLeast = 0.02;
  return probe.second_harmonic ? std::clamp(depth_mm / FocusMm(probe), kLeast, 1.0) : 1.0;
}

double AxialFwhmMm(const Probe& probe, double speed_m_per_s) {
  return 2.0 * std::numbers::ln2 / std::numbers::pi * WavelengthMm(probe, speed_m_per_s) /
         probe.fractional_bandwidth;
}

double SigmaOfFwhm(double fwhm) {
  return fwhm / (2.0 * std::sqrt(2.0 * std::numbers::ln2));
}

double TransmitApertureMm(const Probe& probe) {
  return ReceiveApertureMm(probe, FocusMm(probe));
}

double ReceiveApertureMm(const Probe& probe, double depth_mm) {
  const double full_mm = FullApertureMm(probe);
  const double least_mm = std::min(full_mm, 2.0 * full_mm / probe.elements);
  return std::clamp(depth_mm / probe.f_number, least_mm, full_mm);
}

double OneWayFwhmMm(double aperture_mm, double focus_mm, double depth_mm, double wavelength_mm) {
  const double radius_mm = kRadiusOfAperture * aperture_mm;
  const double geometric_mm = radius_mm * (1.0 - depth_mm / focus_mm);
  const double diffracted_mm = wavelength_mm * depth_mm / (std::numbers::pi * radius_mm);
  return kGaussFwhm * std::hypot(geometric_mm, diffracted_mm);
}

double LateralFwhmMm(const Probe& probe, double depth_mm, double speed_m_per_s) {
  const double wavelength_mm = WavelengthMm(probe, speed_m_per_s);
  double transmit_mm =
      OneWayFwhmMm(TransmitApertureMm(probe), FocusMm(probe), depth_mm, wavelength_mm);
  // Focused everywhere; at the face as wide as its two elements.
  const double aperture_mm = ReceiveApertureMm(probe, depth_mm);
  const double least_mm = kGaussFwhm * kRadiusOfAperture * ReceiveApertureMm(probe, 0.0);
  double received_mm = kSincFwhm * wavelength_mm * depth_mm / aperture_mm;
  if (probe.second_harmonic) {
    transmit_mm /= std::numbers::sqrt2;
    received_mm *= 0.5;
  }
  return ProductFwhm(transmit_mm, std::max(least_mm, received_mm));
}

double ElevationFwhmMm(const Probe& probe, double depth_mm, double speed_m_per_s) {
  const double focus_mm =
      probe.elevation_focus_mm > 0.0 ? probe.elevation_focus_mm : FocusMm(probe);
  const auto one_way_mm = [&](double wavelength_mm) {
    return OneWayFwhmMm(probe.elevation_aperture_mm, focus_mm, depth_mm, wavelength_mm);
  };
  const double wavelength_mm = WavelengthMm(probe, speed_m_per_s);
  const double there_mm = std::numbers::sqrt2 / 2.0 * one_way_mm(wavelength_mm);
  if (!probe.second_harmonic) return there_mm;
  return ProductFwhm(there_mm, one_way_mm(0.5 * wavelength_mm));
}

}  // namespace acus::acoustics
