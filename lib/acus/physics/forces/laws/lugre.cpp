#include "acus/physics/forces/laws/lugre.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {

double LuGreParameters::Stribeck(double speed_mm_per_s) const noexcept {
  return mu_coulomb +
         (mu_static - mu_coulomb) * std::exp(-beta_s_per_mm * std::abs(speed_mm_per_s));
}

double LuGre::Advance(const LuGreParameters& law, double travel_mm, double dt_s,
                      double new_normal_n) noexcept {
  if (new_normal_n > normal_n && new_normal_n > 0.0) bristle_mm *= normal_n / new_normal_n;
  normal_n = new_normal_n;

  const double speed_mm_per_s = travel_mm / dt_s;
  const double kept = law.speed_filter_s > 0.0 ? std::exp(-dt_s / law.speed_filter_s) : 0.0;
  const double before_mm_per_s = kept > 0.0 ? filtered_mm_per_s : speed_mm_per_s;
  filtered_mm_per_s = speed_mm_per_s + (filtered_mm_per_s - speed_mm_per_s) * kept;

  // The mean over the step: with an encoder nothing moves but in steps, in which the filtered speed
  // is at its highest.
  const double g = law.Stribeck(0.5 * (before_mm_per_s + filtered_mm_per_s));
  double bristle_speed_mm_per_s = 0.0;
  double sigma1 = law.sigma1_s_per_mm;
  if (travel_mm != 0.0) {
    const double before_mm = bristle_mm;
    const double steady_mm = std::copysign(g / law.sigma0_per_mm, travel_mm);
    const double left = std::exp(-law.sigma0_per_mm * std::abs(travel_mm) / g);
    bristle_mm = steady_mm + (before_mm - steady_mm) * left;
    bristle_speed_mm_per_s = (bristle_mm - before_mm) / dt_s;
    sigma1 = std::min(sigma1, 4.0 * g / std::abs(speed_mm_per_s));
  }
  return normal_n * (law.sigma0_per_mm * bristle_mm + sigma1 * bristle_speed_mm_per_s +
                     law.sigma2_s_per_mm * filtered_mm_per_s);
}

}  // namespace acus::forces
