#include "acus/physics/tissue/local_compliance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::tissue {
namespace {

constexpr double kLeastLogarithm = 0.2;
constexpr double kLeastShare = 0.02;
}  // namespace

LocalCompliance ShaftCompliance(const mechanics::ElasticTissue& tissue, double element_mm,
                                double radius_mm, double length_mm) {
  const double nu = tissue.poissons_ratio;
  const double shear_n_per_mm = tissue.ShearModulusMpa() * length_mm;
  const auto logarithm = [&](double share) {
    return std::max(std::log(share * element_mm / radius_mm), kLeastLogarithm);
  };
  return {(3.0 - 4.0 * nu) * logarithm(kLateralRadiusShare) /
              (8.0 * std::numbers::pi * shear_n_per_mm * (1.0 - nu)),
          logarithm(kAxialRadiusShare) / (2.0 * std::numbers::pi * shear_n_per_mm)};
}

double LumpRadiusMm(const mechanics::ElasticTissue& tissue, double force_n, bool on_surface,
                    double needle_radius_mm) {
  const double angle = (on_surface ? 2.0 : 4.0) * std::numbers::pi;
  const double radius_mm = std::sqrt(force_n / (angle * tissue.ShearModulusMpa()));
  return std::max(needle_radius_mm, std::min(radius_mm, kLargestLumpMm));
}

double SphereMobilityMm2PerN(const mechanics::ElasticTissue& tissue) {
  const double nu = tissue.poissons_ratio;
  return (5.0 - 6.0 * nu) / (24.0 * std::numbers::pi * tissue.ShearModulusMpa() * (1.0 - nu));
}

double PunchMobilityMm2PerN(const mechanics::ElasticTissue& tissue) {
  return (1.0 - tissue.poissons_ratio) / (4.0 * tissue.ShearModulusMpa());
}

double KernelRadiusMm(double element_mm, double lump_radius_mm) {
  return std::max(kKernelOverSphere * std::max(element_mm, lump_radius_mm), kLeastKernelMm);
}

double NearFieldPerMm(double kernel_radius_mm, double lump_radius_mm) {
  const double missing = 1.0 / lump_radius_mm - kKernelOverSphere / kernel_radius_mm;
  return std::max(missing, kLeastShare / lump_radius_mm);
}

}  // namespace acus::tissue
