#include "acus/scene/scenario/needle_effect.h"

#include <map>

#include "acus/base/config/json_file.h"

namespace acus::scenario {

NeedleEffect ReadNeedleEffect(const nlohmann::json& settings, const std::filesystem::path& folder) {
  static const std::map<std::string, NeedleModelKind> kModels = {
      {"rigid", NeedleModelKind::kRigid},
      {"lateral_beam", NeedleModelKind::kLateralBeam},
      {"bendable", NeedleModelKind::kBendable}};
  NeedleEffect effect;
  effect.model = kModels.at(settings.at("model"));
  effect.axis_lock = settings.at("axis_lock");
  effect.elasticity = config::FindConfig(settings.at("elasticity").get<std::string>(), folder);
  effect.influence_radius_mm = settings.at("influence_radius_mm");
  effect.nodes = settings.at("nodes");
  effect.path_spacing_mm = settings.at("path_spacing_mm");
  effect.tip_stiffness_n_per_mm = settings.at("tip_stiffness_n_per_mm");
  effect.hand_n_per_mm = settings.at("hand").at("stiffness_n_per_mm");
  effect.hand_n_mm_per_rad = settings.at("hand").at("stiffness_n_mm_per_rad");
  effect.kappa_n_per_mm = settings.at("hand").at("kappa_n_per_mm");
  effect.hand_has_potential = settings.at("hand").at("form") != "printed";
  effect.bevel = settings.at("bevel");
  return effect;
}

}  // namespace acus::scenario
