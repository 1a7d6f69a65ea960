#include "acus/scene/scenario/ct_slice_effect.h"

namespace acus::scenario {

CtSliceEffect ReadCtSliceEffect(const nlohmann::json& effect) {
  const nlohmann::json& window = effect.at("window");
  return {effect.at("needle"), window.at("centre_hu"), window.at("width_hu")};
}

}  // namespace acus::scenario
