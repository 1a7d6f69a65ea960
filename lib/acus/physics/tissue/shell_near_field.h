// What a mesh cannot resolve of the dimple under a tip on a membrane.
#pragma once

#include <array>

#include "acus/physics/mechanics/elements/elasticity_table.h"

namespace acus::tissue {

/// The membrane as a plate in tension on an elastic half space
/// (mechanics::MembraneComplianceMmPerN): displacement of a needle's tip less that of a kernel of
/// nodes, for kernels of any radius. Found once, since each value is an integral.
class ShellNearField {
 public:
  ShellNearField(const mechanics::Membrane& membrane, const mechanics::ElasticTissue& beneath,
                 double needle_radius_mm);

  /// mm per N, >= 0; linear between 33 radii up to kWidestMm, constant beyond.
  double MissingMmPerN(double kernel_radius_mm) const noexcept;

 private:
  static constexpr double kWidestMm = 32.0;
  static constexpr int kNumSteps = 32;
  std::array<double, kNumSteps + 1> missing_mm_per_n_{};
};

}  // namespace acus::tissue
