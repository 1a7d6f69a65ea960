#include "acus/physics/fluid/lumen_content.h"

#include <algorithm>

namespace acus::fluid {

Passage LumenContent::Push(const Passage& entering) noexcept {
  const double moved_ml = entering.liquid_ml + entering.gas_volume_ml;
  const double gas_ml = std::max(0.0, volume_ml - liquid_ml) + entering.gas_volume_ml;
  const double wet_ml = liquid_ml + entering.liquid_ml;
  Passage out;
  if (entering.gas_volume_ml > entering.liquid_ml) {
    out.liquid_ml = std::min(moved_ml, wet_ml);
    out.gas_volume_ml = moved_ml - out.liquid_ml;
  } else {
    out.gas_volume_ml = std::min(moved_ml, gas_ml);
    out.liquid_ml = std::min(moved_ml - out.gas_volume_ml, wet_ml);
  }
  const double all_air_ml = air_ml + entering.air_ml;
  out.air_ml = out.gas_volume_ml >= gas_ml ? all_air_ml : all_air_ml * out.gas_volume_ml / gas_ml;
  liquid_ml = wet_ml - out.liquid_ml;
  air_ml = all_air_ml - out.air_ml;
  return out;
}

}  // namespace acus::fluid
