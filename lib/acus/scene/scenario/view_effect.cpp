#include "acus/scene/scenario/view_effect.h"

#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"

namespace acus::scenario {
namespace {

using nlohmann::json;

Eigen::Vector3d VectorOf(const json& numbers) {
  return {numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>()};
}

View3dEffect::Surface SurfaceOf(const json& object) {
  View3dEffect::Surface surface{object.at("tissue"), object.at("opacity"), std::nullopt};
  if (object.contains("colour")) {
    surface.colour = VectorOf(object["colour"]).cast<float>().array() / 255.0F;
  }
  return surface;
}

void ReadCamera(const json& camera, const std::string& where, View3dEffect& effect) {
  effect.from = camera.at("from");
  effect.view_angle_deg = camera.at("view_angle_deg");
  ACUS_REQUIRE(camera.contains("eye_mm") == camera.contains("focus_mm"), where,
               "/camera: eye_mm and focus_mm go together; give both, or `from`");
  if (!camera.contains("eye_mm")) return;
  effect.eye_in_ct_mm = VectorOf(camera["eye_mm"]);
  effect.focus_in_ct_mm = VectorOf(camera["focus_mm"]);
  effect.up_in_ct = VectorOf(camera.at("up"));
}

}  // namespace

View3dEffect ReadView3dEffect(const json& object, const std::string& where) {
  View3dEffect effect;
  effect.width_px = object.at("width_px");
  effect.height_px = object.at("height_px");
  effect.rate_hz = object.at("rate_hz");
  ReadCamera(object.at("camera"), where, effect);
  for (const json& layer : object.at("layers")) {
    effect.layers.push_back({layer.at("preset"), layer.at("opacity")});
  }
  for (const json& surface : object.at("surfaces")) effect.surfaces.push_back(SurfaceOf(surface));
  ACUS_REQUIRE(!effect.layers.empty() || !effect.surfaces.empty(), where,
               ": there is nothing to show; give a layer of the CT, or a surface");
  effect.surface_grid_mm = object.at("surface_grid_mm");
  effect.needle = object.at("needle");
  effect.probe = object.at("probe");
  effect.picture = object.at("picture");
  effect.shadows = object.at("shadows");
  effect.tool_shine = object.at("tool_shine");
  effect.supersampling = object.at("supersampling");
  effect.step_mm = object.at("step_mm");
  effect.inverse_iterations = object.at("inverse_iterations");
  effect.warp_tolerance_mm = object.at("warp_tolerance_mm");
  return effect;
}

}  // namespace acus::scenario
