#include "acus/physics/tissue/membrane_dimple.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::tissue {
namespace {

/// Energy over E t w^4 / a^2.
constexpr double kEnergyFactor = 8.0 * std::numbers::pi / 63.0 * 625.0 / 81.0;
/// Depth of Schwerin's dimple less its mean over the kernel: 6 times the integral of s^(5/3) (1 -
/// s^2)^2.
constexpr double kPointOverKernel = 6.0 * (3.0 / 8.0 - 3.0 / 7.0 + 3.0 / 20.0);

}  // namespace

double MembraneDimple::ForceN(double moved_mm) const noexcept {
  const double w = std::max(moved_mm, 0.0);
  return 4.0 * kEnergyFactor * stretching_n_per_mm * w * w * w / (radius_mm * radius_mm);
}

double MembraneDimple::SlopeNPerMm(double moved_mm) const noexcept {
  const double w = std::max(moved_mm, 0.0);
  return 12.0 * kEnergyFactor * stretching_n_per_mm * w * w / (radius_mm * radius_mm);
}

double MembraneDimple::NearFieldMmPerN(double linear_mm_per_n, double force_n) const noexcept {
  if (stretching_n_per_mm <= 0.0 || force_n <= 0.0) return linear_mm_per_n;
  const double stretched_mm =
      kPointOverKernel *
      std::cbrt(3.0 * force_n * radius_mm * radius_mm / (std::numbers::pi * stretching_n_per_mm));
  return linear_mm_per_n / (1.0 + linear_mm_per_n * force_n / stretched_mm);
}

double DimpleRadiusMm(double stretching_n_per_mm, double ground_mpa, double moved_mm,
                      double least_mm) noexcept {
  const double w = std::max(moved_mm, 0.0);
  const double free_mm = std::cbrt(4.0 * kEnergyFactor * stretching_n_per_mm * w * w / ground_mpa);
  return std::max(least_mm, std::min(free_mm, kWidestDimpleMm));
}

}  // namespace acus::tissue
