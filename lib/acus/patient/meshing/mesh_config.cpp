#include "acus/patient/meshing/mesh_config.h"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::meshing {
namespace {

using nlohmann::json;

Eigen::Vector3d PointFromJson(const json& values) {
  return {values.at(0).get<double>(), values.at(1).get<double>(), values.at(2).get<double>()};
}

Corridor CorridorFromJson(const json& document) {
  return {PointFromJson(document.at("from_mm")), PointFromJson(document.at("to_mm")),
          document.at("radius_mm").get<double>(), document.at("element_size_mm").get<double>()};
}

}  // namespace

MeshConfig MeshConfigFromJson(const json& document) {
  MeshConfig out;
  const json& sizes = document.at("element_size_mm");
  out.labels.sizes.interface_mm = sizes.at("interface").get<double>();
  out.labels.sizes.skin_mm = sizes.at("skin").get<double>();
  out.labels.sizes.interior_mm = sizes.at("interior").get<double>();
  if (document.contains("corridor")) {
    out.labels.sizes.corridor = CorridorFromJson(document.at("corridor"));
  }
  if (document.contains("refinement")) {
    out.labels.sizes.finest_mm = document.at("refinement").at("finest_mm").get<double>();
    out.labels.wanted_nodes = document.at("refinement").at("nodes").get<std::size_t>();
  }
  document.at("conforming_tissues").get_to(out.labels.conforming_tissues);
  document.at("fixed_tissues").get_to(out.labels.fixed_tissues);
  out.labels.smoothing_mm = document.at("smoothing_mm").get<double>();
  out.labels.min_dihedral_deg = document.at("min_dihedral_deg").get<double>();
  out.labels.volume_tolerance = document.at("volume_tolerance").get<double>();
  out.labels.min_island_share = document.at("min_island_share").get<double>();
  out.labels.max_nodes = document.at("max_nodes").get<std::size_t>();
  const json& surface = document.at("surface");
  out.surface.tetgen.element_size_mm = surface.at("element_size_mm").get<double>();
  out.surface.tetgen.max_radius_edge_ratio = surface.at("max_radius_edge_ratio").get<double>();
  out.surface.tetgen.time_limit_s = surface.at("time_limit_s").get<double>();
  out.surface.min_dihedral_deg = out.labels.min_dihedral_deg;
  return out;
}

Eigen::Vector3d PointFromText(const std::string& text, const std::string& what) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  const char* at = text.data();
  const char* end = at + text.size();
  bool is_sound = true;
  for (int d = 0; d < 3 && is_sound; ++d) {
    const auto [rest, error] = std::from_chars(at, end, out[d]);
    is_sound = error == std::errc() && std::isfinite(out[d]) &&
               (d == 2 ? rest == end : rest != end && *rest == ',');
    at = rest + 1;
  }
  ACUS_REQUIRE(is_sound, what, ": '", text,
               "' is not a point; write x,y,z in mm, such as 1.5,-20,340");
  return out;
}

void SetCorridor(MeshConfig& config, const std::string& from, const std::string& to) {
  if (!config.labels.sizes.corridor) {
    const json filled = config::CheckedConfig(
        {{"format", "acus-mesh/1"}, {"corridor", {{"from_mm", {0, 0, 0}}, {"to_mm", {0, 0, 0}}}}},
        "acus-mesh", "corridor");
    config.labels.sizes.corridor = CorridorFromJson(filled.at("corridor"));
  }
  config.labels.sizes.corridor->from_mm = PointFromText(from, "--corridor-from");
  config.labels.sizes.corridor->to_mm = PointFromText(to, "--corridor-to");
}

void RequestCondensation(MeshConfig& config, const json& document,
                         const std::filesystem::path& relative_to, const std::string& probe_at) {
  ACUS_REQUIRE(config.labels.sizes.corridor.has_value(),
               "condensation needs the needle's way: give --corridor-from and --corridor-to, or "
               "\"corridor\" in the configuration");
  config.condense = CondenseSettingsFromJson(document, relative_to, probe_at);
}

}  // namespace acus::meshing
