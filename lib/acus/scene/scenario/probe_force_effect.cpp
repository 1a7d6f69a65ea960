#include "acus/scene/scenario/probe_force_effect.h"

#include <map>

#include "acus/base/config/json_file.h"

namespace acus::scenario {

ProbeForceEffect ReadProbeForce(const nlohmann::json& settings,
                                const std::filesystem::path& folder) {
  const nlohmann::json& multi_proxy = settings.at("multi_proxy");
  ProbeForceEffect effect;
  static const std::map<std::string, ProbeForceModelKind> kModels = {
      {"vidal", ProbeForceModelKind::kVidal},
      {"multi_proxy", ProbeForceModelKind::kMultiProxy},
      {"tissue", ProbeForceModelKind::kTissue}};
  effect.model = kModels.at(settings.at("model"));
  effect.table = config::FindConfig(settings.at("table").get<std::string>(), folder);
  effect.press_mm = settings.at("press_mm");
  effect.reads_labels =
      effect.model == ProbeForceModelKind::kMultiProxy && multi_proxy.at("reads") == "labels";
  effect.is_fingertip = multi_proxy.at("tool") == "fingertip";
  effect.num_proxies = multi_proxy.at("proxies");
  effect.face_width_mm = multi_proxy.at("face_width_mm");
  effect.fingertip_radius_mm = multi_proxy.at("fingertip_radius_mm");
  effect.presses_images =
      effect.model == ProbeForceModelKind::kMultiProxy && multi_proxy.at("image");
  return effect;
}

}  // namespace acus::scenario
