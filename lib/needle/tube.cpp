#include "needle/tube.h"

#include <cmath>
#include <numbers>

#include "config/json_file.h"
#include "core/error.h"

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

RodProperties RodOf(const Tube& tube, double length_mm) {
  RodProperties rod;
  rod.length_mm = length_mm;
  rod.bending_n_mm2 = tube.BendingStiffnessNMm2();
  rod.twist_n_mm2 = tube.TwistStiffnessNMm2();
  return rod;
}

RodProperties ReadRod(const std::filesystem::path& needle) {
  const nlohmann::json document = config::ReadConfig(needle, "acus-needle");
  const Tube tube{document.at("outer_diameter_mm"), document.at("inner_diameter_mm"),
                  document.at("youngs_modulus_gpa").get<double>() * 1e3};
  ACUS_REQUIRE(tube.inner_diameter_mm < tube.outer_diameter_mm, needle.string(),
               ": /inner_diameter_mm: is ", tube.inner_diameter_mm,
               "; it must be below outer_diameter_mm, ", tube.outer_diameter_mm);
  return RodOf(tube, document.at("length_mm"));
}

}  // namespace acus::needle
