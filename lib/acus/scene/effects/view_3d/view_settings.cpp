#include "acus/scene/effects/view_3d/view_settings.h"

#include <nlohmann/json.hpp>

namespace acus::effects {
namespace {

using nlohmann::json;

Eigen::Vector3d VectorOf(const json& numbers) {
  return {numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>()};
}

View3dSettings::Surface SurfaceOf(const json& object) {
  View3dSettings::Surface surface{object.at("tissue"), object.at("opacity"), std::nullopt};
  if (object.contains("colour")) {
    surface.colour = VectorOf(object["colour"]).cast<float>().array() / 255.0F;
  }
  return surface;
}

void ReadCamera(const json& camera, View3dSettings& settings) {
  settings.from = camera.at("from");
  settings.view_angle_deg = camera.at("view_angle_deg");
  if (!camera.contains("eye_mm")) return;
  settings.eye_in_ct_mm = VectorOf(camera.at("eye_mm"));
  settings.focus_in_ct_mm = VectorOf(camera.at("focus_mm"));
  settings.up_in_ct = VectorOf(camera.at("up"));
}

}  // namespace

View3dSettings ReadView3dSettings(const json& object) {
  View3dSettings settings;
  settings.width_px = object.at("width_px");
  settings.height_px = object.at("height_px");
  ReadCamera(object.at("camera"), settings);
  settings.maximum_projection = object.at("projection") == "maximum";
  const json& window = object.at("window_hu");
  settings.window_hu = {window[0].get<double>(), window[1].get<double>()};
  for (const json& layer : object.at("layers")) {
    settings.layers.push_back({layer.at("preset"), layer.at("opacity")});
  }
  for (const json& surface : object.at("surfaces")) settings.surfaces.push_back(SurfaceOf(surface));
  if (object.contains("camera_path")) {
    settings.camera_path = object.at("camera_path").get<std::string>();
  }
  settings.beside_rest = object.at("beside") == "rest";
  settings.event_stills = object.at("event_stills");
  settings.surface_grid_mm = object.at("surface_grid_mm");
  settings.needle = object.at("needle");
  settings.probe = object.at("probe");
  settings.force_arrow_mm_per_n = object.at("force_arrow_mm_per_n");
  settings.pressed = object.at("pressed");
  settings.shadows = object.at("shadows");
  settings.tool_shine = object.at("tool_shine");
  settings.supersampling = object.at("supersampling");
  settings.step_mm = object.at("step_mm");
  settings.inverse_iterations = object.at("inverse_iterations");
  settings.warp_tolerance_mm = object.at("warp_tolerance_mm");
  settings.pixel_tolerance = object.at("pixel_tolerance");
  return settings;
}

}  // namespace acus::effects
