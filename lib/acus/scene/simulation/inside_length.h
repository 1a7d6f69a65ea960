// Length of a straight line inside tissue: the depth of a point below the skin.
#pragma once

namespace acus::simulation {

/// Length from the start of a line to where `in_air(mm)` becomes true along it: searched in steps
/// of `look_mm`, then by bisection of the last one. 0 if the start is in air, or there is no air
/// within `most_mm`.
template <class InAir>
double InsideLengthMm(const InAir& in_air, double look_mm, double most_mm) noexcept {
  constexpr int kBisections = 10;
  if (in_air(0.0)) return 0.0;
  double inside_mm = 0.0;
  double outside_mm = look_mm;
  while (!in_air(outside_mm)) {
    inside_mm = outside_mm;
    outside_mm += look_mm;
    if (outside_mm > most_mm) return 0.0;
  }
  for (int i = 0; i < kBisections; ++i) {
    const double middle_mm = 0.5 * (inside_mm + outside_mm);
    (in_air(middle_mm) ? outside_mm : inside_mm) = middle_mm;
  }
  return inside_mm;
}

}  // namespace acus::simulation
