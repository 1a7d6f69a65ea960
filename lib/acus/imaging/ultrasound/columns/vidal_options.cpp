#include "acus/imaging/ultrasound/columns/vidal_options.h"

#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::ultrasound {
namespace {

VidalOptions VidalOptionsFromJson(const nlohmann::json& json, const std::string& label) {
  VidalOptions options;
  options.name = json.at("name");
  options.grey = ReadHuCurve(json, "grey", label);
  const auto& shadow = json.at("shadow");
  options.shadow = shadow.at("on");
  options.bone_above_hu = shadow.at("bone_above_hu");
  options.gas_below_hu = shadow.at("gas_below_hu");
  options.surface_mm = shadow.at("surface_mm");
  options.shadow_share = shadow.at("share");
  ACUS_REQUIRE(options.gas_below_hu < options.bone_above_hu, label, ": /shadow: gas is below ",
               options.gas_below_hu, " HU and bone above ", options.bone_above_hu,
               " HU; the first must be the lower one");
  options.needle_share = shadow.at("needle_share");
  const auto& noise = json.at("noise");
  options.noise = noise.at("on");
  options.noise_grain_mm = noise.at("grain_mm");
  options.noise_contrast = noise.at("contrast");
  const auto& reflections = json.at("reflections");
  options.reflections = reflections.at("on");
  options.sobel_span_mm = reflections.at("span_mm");
  options.reflection_min_hu_per_mm = reflections.at("min_hu_per_mm");
  options.reflection_full_hu_per_mm = reflections.at("full_hu_per_mm");
  options.reflection_max_angle_rad =
      reflections.at("max_angle_deg").get<double>() * std::numbers::pi / 180.0;
  options.reflection_grey = reflections.at("grey");
  ACUS_REQUIRE(options.reflection_full_hu_per_mm >= options.reflection_min_hu_per_mm, label,
               ": /reflections/full_hu_per_mm: is ", options.reflection_full_hu_per_mm,
               ", below min_hu_per_mm (", options.reflection_min_hu_per_mm, ")");
  options.contrast = json.at("contrast");
  options.brightness = json.at("brightness");
  options.coupling_gap_mm = json.at("coupling_gap_mm");
  return options;
}

}  // namespace

VidalOptions ReadVidalOptions(const std::filesystem::path& path) {
  return VidalOptionsFromJson(config::ReadConfig(path, "acus-image-vidal"), path.string());
}

VidalOptions DefaultVidalOptions() {
  const nlohmann::json empty = {{"format", "acus-image-vidal/1"}};
  return VidalOptionsFromJson(config::CheckedConfig(empty, "acus-image-vidal", "default image"),
                              "default image");
}

}  // namespace acus::ultrasound
