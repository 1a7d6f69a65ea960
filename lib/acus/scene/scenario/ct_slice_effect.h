// The settings of the CT slice in a scenario.
#pragma once

#include <nlohmann/json.hpp>

namespace acus::scenario {

/// The CT in the plane of the probe's image.
struct CtSliceEffect {
  bool needle = true;
  double centre_hu = 0.0;  ///< Middle grey.
  double width_hu = 0.0;   ///< From black to white.
};

/// @param effect  /effects/ct_slice, checked against the schema.
CtSliceEffect ReadCtSliceEffect(const nlohmann::json& effect);

}  // namespace acus::scenario
