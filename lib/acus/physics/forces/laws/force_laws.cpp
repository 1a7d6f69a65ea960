#include "acus/physics/forces/laws/force_laws.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace acus::forces {

double PuncturePolynomial::ForceN(double indentation_mm) const noexcept {
  const double x = std::max(0.0, indentation_mm);
  return (a1_n_per_mm + a2_n_per_mm2 * x) * x;
}

double PuncturePolynomial::PunctureDepthMm() const noexcept {
  if (puncture_n <= 0.0) return 0.0;
  // The positive root in the form that does not cancel when a2 is small.
  const double root =
      std::sqrt(a1_n_per_mm * a1_n_per_mm + 4.0 * a2_n_per_mm2 * puncture_n) + a1_n_per_mm;
  return root > 0.0 ? 2.0 * puncture_n / root : std::numeric_limits<double>::infinity();
}

double TrackingWall::Advance(double tip_mm, double cutting_n, double stiffness_n_per_mm) noexcept {
  wall_mm = std::max(wall_mm, tip_mm - cutting_n / stiffness_n_per_mm);
  return std::clamp(stiffness_n_per_mm * (tip_mm - wall_mm), 0.0, cutting_n);
}

double TrackingWall::AdvanceBothWays(double tip_mm, double cutting_n, double withdrawal_n,
                                     double stiffness_n_per_mm) noexcept {
  wall_mm = std::clamp(wall_mm, tip_mm - cutting_n / stiffness_n_per_mm,
                       tip_mm + withdrawal_n / stiffness_n_per_mm);
  return std::clamp(stiffness_n_per_mm * (tip_mm - wall_mm), -withdrawal_n, cutting_n);
}

double BristleFriction::Slide(double travel_mm, double z0_mm) noexcept {
  if (travel_mm != 0.0) {
    const double steady_mm = std::copysign(z0_mm, travel_mm);
    deflection_mm =
        steady_mm + (deflection_mm - steady_mm) * std::exp(-std::abs(travel_mm) / z0_mm);
  }
  return std::clamp(deflection_mm / z0_mm, -1.0, 1.0);
}

double BoneSpring::ForceN(double penetration_mm, double speed_mm_per_s) const noexcept {
  if (penetration_mm <= 0.0) return 0.0;
  return std::clamp(stiffness_n_per_mm * penetration_mm + damping_n_s_per_mm * speed_mm_per_s, 0.0,
                    largest_n);
}

}  // namespace acus::forces
