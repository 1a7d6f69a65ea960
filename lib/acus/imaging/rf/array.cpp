#include "acus/imaging/rf/array.h"

#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::rf {

Array ArrayOf(const acoustics::Probe& probe, double element_width_mm) {
  const int count = probe.elements;
  ACUS_REQUIRE(count >= 1, "probe '", probe.name, "': has ", count,
               " elements; at least 1 is needed");
  const double pitch_mm = probe.pitch_mm > 0.0 ? probe.pitch_mm : probe.ArrayLengthMm() / count;
  ACUS_REQUIRE(element_width_mm >= 0.0 && element_width_mm <= pitch_mm, "probe '", probe.name,
               "': the width of its elements is ", element_width_mm,
               " mm; it is between 0 (the pitch) ", "and the pitch, ", pitch_mm, " mm");
  Array array;
  array.element_width_mm = element_width_mm > 0.0 ? element_width_mm : pitch_mm;
  for (int e = 0; e < count; ++e) {
    const double along_mm = (e - 0.5 * (count - 1)) * pitch_mm;
    Element element;
    if (probe.kind == acoustics::ProbeKind::kCurvilinear) {
      const double angle = along_mm / probe.radius_mm;
      element.normal = {std::sin(angle), std::cos(angle)};
      element.position_mm = probe.radius_mm * (element.normal - Eigen::Vector2d::UnitY());
    } else {
      element.position_mm = {along_mm, 0.0};
    }
    array.elements.push_back(element);
  }
  return array;
}

double Directivity(double element_width_mm, double frequency_mhz, double sound_speed_mm_per_us,
                   double cos_angle) {
  if (cos_angle <= 0.0) return 0.0;
  const double sin_angle = std::sqrt(std::max(0.0, 1.0 - cos_angle * cos_angle));
  const double u =
      std::numbers::pi * element_width_mm * frequency_mhz * sin_angle / sound_speed_mm_per_us;
  return cos_angle * (u < 1e-6 ? 1.0 : std::sin(u) / u);
}

}  // namespace acus::rf
