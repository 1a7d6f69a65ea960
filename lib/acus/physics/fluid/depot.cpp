#include "acus/physics/fluid/depot.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::fluid {

Depot DepotOf(const FluidTissue& tissue, const TissueFluid& fluid) noexcept {
  Depot out;
  out.liquid_ml = std::max(0.0, fluid.liquid_ml);
  out.air_ml = std::max(0.0, fluid.air_ml);
  out.wet_share = tissue.fluid_share;
  const double volume_mm3 = 1e3 * (out.liquid_ml + out.air_ml) / tissue.fluid_share;
  out.width_radius_mm = std::cbrt(0.75 * volume_mm3 / (std::numbers::pi * tissue.flatness));
  out.thickness_radius_mm = tissue.flatness * out.width_radius_mm;
  return out;
}

}  // namespace acus::fluid
