#include "acus/patient/meshing/mesh_config.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/base/math/point_text.h"
#include "acus/data/transforms/landmarks.h"

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

namespace {

void SetCorridorBetween(MeshConfig& config, const Eigen::Vector3d& from_mm,
                        const Eigen::Vector3d& to_mm) {
  if (!config.labels.sizes.corridor) {
    const json filled = config::CheckedConfig(
        {{"format", "acus-mesh/1"}, {"corridor", {{"from_mm", {0, 0, 0}}, {"to_mm", {0, 0, 0}}}}},
        "acus-mesh", "corridor");
    config.labels.sizes.corridor = CorridorFromJson(filled.at("corridor"));
  }
  config.labels.sizes.corridor->from_mm = from_mm;
  config.labels.sizes.corridor->to_mm = to_mm;
}

}  // namespace

void SetCorridor(MeshConfig& config, const std::string& from, const std::string& to) {
  SetCorridorBetween(config, math::PointFromText(from, "--corridor-from"),
                     math::PointFromText(to, "--corridor-to"));
}

void SetCorridorOfFile(MeshConfig& config, const std::filesystem::path& file) {
  const transforms::Landmarks points = transforms::ReadLandmarks(file);
  const auto point = [&points](const char* name) -> Eigen::Vector3d {
    const auto found = std::ranges::find(points.names, name);
    ACUS_REQUIRE(found != points.names.end(), "--corridor ", points.source, ": has no point \"",
                 name, "\"; it must have entry and target, the ends of the needle's path");
    return points.points_mm.col(found - points.names.begin());
  };
  SetCorridorBetween(config, point("entry"), point("target"));
}

void RequestCondensation(MeshConfig& config, const json& document,
                         const std::filesystem::path& relative_to, const std::string& probe_at) {
  ACUS_REQUIRE(config.labels.sizes.corridor.has_value(),
               "condensation needs the needle's path: give --corridor, or --corridor-from and "
               "--corridor-to, or "
               "\"corridor\" in the configuration");
  config.condense = CondenseSettingsFromJson(document, relative_to, probe_at);
}

}  // namespace acus::meshing
