#include "acus/physics/fluid/lumen.h"

#include <cmath>
#include <numbers>

namespace acus::fluid {
namespace {

/// mPa s x mm / mm^4 in kPa s / ml: 1e-3 Pa s x 1e-3 m / 1e-12 m^4 = 1e6 Pa s/m^3 = 1e-3 kPa s/ml.
double PoiseuilleKpaSPerMl(double viscosity_mpa_s, double length_mm, double diameter_mm) noexcept {
  const double d2_mm2 = diameter_mm * diameter_mm;
  return 1e-3 * 128.0 * viscosity_mpa_s * length_mm / (std::numbers::pi * d2_mm2 * d2_mm2);
}

double SectionMm2(double diameter_mm) noexcept {
  return 0.25 * std::numbers::pi * diameter_mm * diameter_mm;
}

}  // namespace

double Lumen::VolumeMl() const noexcept {
  return 1e-3 * (SectionMm2(inner_diameter_mm) * (length_mm - tip_length_mm) +
                 SectionMm2(tip_inner_diameter_mm) * tip_length_mm);
}

double LumenResistance::FlowMlPerS(double pressure_kpa) const noexcept {
  const double magnitude_kpa = std::abs(pressure_kpa);
  const double root = std::sqrt(linear_kpa_s_per_ml * linear_kpa_s_per_ml +
                                4.0 * quadratic_kpa_s2_per_ml2 * magnitude_kpa);
  // The form that neither cancels nor divides by K.
  return std::copysign(2.0 * magnitude_kpa / (linear_kpa_s_per_ml + root), pressure_kpa);
}

LumenResistance ResistanceOf(const Lumen& lumen, const Fluid& fluid, double kinetic_loss) noexcept {
  LumenResistance out;
  out.linear_kpa_s_per_ml = PoiseuilleKpaSPerMl(
      fluid.viscosity_mpa_s, lumen.length_mm - lumen.tip_length_mm, lumen.inner_diameter_mm);
  double narrow_mm = lumen.inner_diameter_mm;
  if (lumen.tip_length_mm > 0.0) {
    out.linear_kpa_s_per_ml += PoiseuilleKpaSPerMl(fluid.viscosity_mpa_s, lumen.tip_length_mm,
                                                   lumen.tip_inner_diameter_mm);
    narrow_mm = lumen.tip_inner_diameter_mm;
  }
  // kg/m^3 x (ml/s / mm^2)^2 = kg/m^3 x (m/s)^2 = Pa.
  const double section_mm2 = SectionMm2(narrow_mm);
  out.quadratic_kpa_s2_per_ml2 =
      0.5e-3 * kinetic_loss * fluid.density_kg_per_m3 / (section_mm2 * section_mm2);
  return out;
}

}  // namespace acus::fluid
