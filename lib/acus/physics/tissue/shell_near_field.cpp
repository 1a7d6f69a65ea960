#include "acus/physics/tissue/shell_near_field.h"

#include <algorithm>
#include <cmath>

#include "acus/physics/tissue/local_compliance.h"

namespace acus::tissue {

ShellNearField::ShellNearField(const mechanics::Membrane& membrane,
                               const mechanics::ElasticTissue& beneath, double needle_radius_mm) {
  const double shear_mpa = beneath.ShearModulusMpa();
  const double nu = beneath.poissons_ratio;
  const double tip_kernel_mm = kKernelOverSphere * needle_radius_mm;
  const double tip_mm_per_n =
      mechanics::MembraneComplianceMmPerN(membrane, shear_mpa, nu, tip_kernel_mm);
  for (int step = 1; step <= kNumSteps; ++step) {
    const double radius_mm = kWidestMm * step / kNumSteps;
    if (radius_mm <= tip_kernel_mm) continue;
    missing_mm_per_n_[static_cast<std::size_t>(step)] =
        tip_mm_per_n - mechanics::MembraneComplianceMmPerN(membrane, shear_mpa, nu, radius_mm);
  }
}

double ShellNearField::MissingMmPerN(double kernel_radius_mm) const noexcept {
  const double at = std::clamp(kernel_radius_mm / kWidestMm * kNumSteps, 0.0, 1.0 * kNumSteps);
  const int step = std::min(static_cast<int>(at), kNumSteps - 1);
  const double share = at - step;
  const std::size_t n = static_cast<std::size_t>(step);
  return (1.0 - share) * missing_mm_per_n_[n] + share * missing_mm_per_n_[n + 1];
}

}  // namespace acus::tissue
