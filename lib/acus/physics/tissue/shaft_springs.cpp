#include "acus/physics/tissue/shaft_springs.h"

#include <cmath>
#include <numbers>

namespace acus::tissue {

ShaftStiffness ShaftInCylinder(double shaft_radius_mm, double outer_radius_mm) noexcept {
  const double log_ratio = std::log(outer_radius_mm / shaft_radius_mm);
  const double a2 = shaft_radius_mm * shaft_radius_mm;
  const double r2 = outer_radius_mm * outer_radius_mm;
  return {.along = 2.0 * std::numbers::pi / log_ratio,
          .across = 4.0 * std::numbers::pi / (log_ratio - (r2 - a2) / (r2 + a2))};
}

}  // namespace acus::tissue
