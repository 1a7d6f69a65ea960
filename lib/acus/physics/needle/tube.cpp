#include "acus/physics/needle/tube.h"

#include <cmath>
#include <numbers>

namespace acus::needle {

double Tube::SecondMomentMm4() const noexcept {
  const double outer2 = outer_diameter_mm * outer_diameter_mm;
  const double inner2 = inner_diameter_mm * inner_diameter_mm;
  return std::numbers::pi / 64.0 * (outer2 * outer2 - inner2 * inner2);
}

double Tube::BendingStiffnessNMm2() const noexcept {
  return youngs_modulus_mpa * SecondMomentMm4();
}

double Tube::TwistStiffnessNMm2() const noexcept {
  return youngs_modulus_mpa / (1.0 + poisson_ratio) * SecondMomentMm4();
}

double Tube::EndStiffnessNPerMm(double length_mm) const noexcept {
  return 3.0 * youngs_modulus_mpa * SecondMomentMm4() / (length_mm * length_mm * length_mm);
}

RodProperties RodOf(const Tube& tube, double length_mm) {
  RodProperties rod;
  rod.length_mm = length_mm;
  rod.bending_n_mm2 = tube.BendingStiffnessNMm2();
  rod.twist_n_mm2 = tube.TwistStiffnessNMm2();
  return rod;
}

}  // namespace acus::needle
