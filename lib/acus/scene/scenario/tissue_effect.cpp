#include "acus/scene/scenario/tissue_effect.h"

#include <map>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::scenario {

TissueEffect ReadTissueEffect(const nlohmann::json& settings, const std::filesystem::path& folder) {
  static const std::map<std::string, TissueModelKind> kModels = {
      {"displacement_functions", TissueModelKind::kDisplacementFunctions},
      {"springs", TissueModelKind::kSprings},
      {"fe_2d", TissueModelKind::kPlane2010},
      {"fe_3d", TissueModelKind::kFem3d}};
  TissueEffect effect;
  effect.model = kModels.at(settings.at("model"));
  effect.elasticity = config::FindConfig(settings.at("elasticity").get<std::string>(), folder);
  effect.table = config::FindConfig(settings.at("table").get<std::string>(), folder);
  effect.image = settings.at("image");
  effect.pressed_by_probe = settings.at("pressed_by_probe");
  effect.warp_spacing_mm = settings.at("warp_spacing_mm");
  effect.inverse_iterations = settings.at("inverse_iterations");
  const nlohmann::json& springs = settings.at("springs");
  effect.path_spacing_mm = springs.at("path_spacing_mm");
  const nlohmann::json& functions = settings.at("displacement_functions");
  effect.printed_form = functions.at("form") == "printed";
  effect.tip_length_mm = functions.at("tip_length_mm");
  effect.influence_radius_mm =
      (effect.model == TissueModelKind::kSprings ? springs : functions).at("influence_radius_mm");
  const nlohmann::json& plane = settings.at("fe_2d");
  effect.plane_spacing_mm = plane.at("spacing_mm");
  effect.plane_width_mm = plane.at("width_mm");
  effect.plane_turned = plane.at("turned_planes");
  effect.plane_full_update = plane.at("update") == "full";
  ACUS_REQUIRE(effect.model != TissueModelKind::kPlane2010 || !effect.plane_full_update ||
                   effect.plane_turned == 0,
               "/effects/tissue/fe_2d/update: \"full\" with turned_planes ", effect.plane_turned,
               "; a plane that turns has the restricted update: set turned_planes to 0");
  effect.plane_beyond_mm = plane.at("beyond_mm");
  effect.plane_thickness_mm = plane.at("thickness_mm");
  effect.element = settings.at("fe_3d").at("element");
  effect.contact_spacing_mm = settings.at("fe_3d").at("contact_spacing_mm");
  effect.probe_contact = settings.at("fe_3d").at("probe_contact");
  effect.finite_strain = settings.at("fe_3d").at("law") == "finite_strain";
  effect.strain_nodes = settings.at("fe_3d").at("strain_nodes");
  effect.strain_iterations = settings.at("fe_3d").at("strain_iterations");
  return effect;
}

}  // namespace acus::scenario
