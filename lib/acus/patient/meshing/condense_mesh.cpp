#include "acus/patient/meshing/condense_mesh.h"

#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/math/point_text.h"
#include "acus/patient/meshing/mesh_config.h"
#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "acus/physics/mechanics/elements/element_names.h"

namespace acus::meshing {
namespace {

using mechanics::FreeNodes;
using nlohmann::json;

mechanics::SkinPatch PatchFromJson(const json& probe) {
  const json& place = probe.at("place_mm");
  return {{place.at(0).get<double>(), place.at(1).get<double>(), place.at(2).get<double>()},
          probe.at("radius_mm").get<double>()};
}

FreeNodes FindFreeNodesOf(const mesh::TetraMesh& mesh, const RunContext& context) {
  FreeNodes free = mechanics::FindFreeNodes(mesh);
  for (const mechanics::LoosePiece& piece : free.loose) {
    context.Warn(Message("a piece of ", piece.num_tetrahedra, " tetrahedra about (",
                         piece.centre_mm.x(), ", ", piece.centre_mm.y(), ", ", piece.centre_mm.z(),
                         ") mm is held by nothing; it is excluded from the condensation"));
  }
  return free;
}

json Report(const mesh::TetraMesh& mesh, const FreeNodes& free,
            const mechanics::Condensation& condensation, const mechanics::ComplianceFileCost& file,
            std::size_t num_visible) {
  const mechanics::CondensationCost& cost = condensation.cost();
  return {{"format", "acus-condensation/1"},
          {"nodes", mesh.nodes_mm.cols()},
          {"tetrahedra", mesh.tetrahedra.cols()},
          {"free_nodes", free.mesh_node.size()},
          {"loose_pieces", free.loose.size()},
          {"reachable_nodes", condensation.nodes().size()},
          {"visible_nodes", num_visible},
          {"cpu_s",
           {{"assemble", cost.assemble_s},
            {"factor_and_invert", cost.factor_s},
            {"image_block", file.image_s},
            {"write", file.write_s}}},
          {"factor_mib", cost.factor_mib},
          {"peak_memory_mib", PeakMemoryMib()},
          {"file_mib", {{"compliance", file.compliance_mib}, {"image_block", file.image_mib}}},
          {"key", file.key}};
}

}  // namespace

CondenseSettings CondenseSettingsFromJson(const json& document,
                                          const std::filesystem::path& relative_to,
                                          const std::string& probe_at) {
  json from = document.at("condensation");
  if (!probe_at.empty() && !from.contains("probe")) {
    from["probe"] = config::CheckedConfig(
        {{"format", "acus-mesh/1"}, {"condensation", {{"probe", {{"place_mm", {0, 0, 0}}}}}}},
        "acus-mesh", "probe")["condensation"]["probe"];
  }
  CondenseSettings out;
  out.corridor_radius_mm = from.at("corridor_radius_mm").get<double>();
  out.tip_reach_mm = from.at("tip_reach_mm").get<double>();
  if (from.contains("probe")) out.probe = PatchFromJson(from.at("probe"));
  if (!probe_at.empty()) out.probe->centre_mm = math::PointFromText(probe_at, "--probe-at");
  out.image_radius_mm = from.at("image_radius_mm").get<double>();
  out.storage =
      from.at("storage") == "float" ? mechanics::Storage::kFloat : mechanics::Storage::kDouble;
  out.element =
      mechanics::ElementNamed(from.at("element").get<std::string>(), "/condensation/element");
  out.elasticity = mechanics::ReadElasticityTable(
                       config::FindConfig(from.at("elasticity").get<std::string>(), relative_to))
                       .OfPatient(from.at("stiffness_seed"));
  out.max_memory_mib = from.at("max_memory_mib").get<double>();
  return out;
}

void WriteCondensed(const std::filesystem::path& folder, const mesh::TetraMesh& mesh,
                    const Corridor& corridor, const CondenseSettings& settings,
                    const RunContext& context) {
  const FreeNodes free = FindFreeNodesOf(mesh, context);
  const mechanics::Capsule reach{corridor.from_mm, corridor.to_mm, settings.corridor_radius_mm};
  std::vector<int> reachable = mechanics::NeedleNodes(mesh, free, reach, settings.tip_reach_mm);
  if (settings.probe) {
    reachable = mechanics::Joined(reachable, mechanics::SkinNodes(mesh, free, *settings.probe));
  }
  std::vector<int> visible;
  if (settings.image_radius_mm > 0.0) {
    visible = mechanics::Joined(
        reachable,
        mechanics::NodesInside(mesh, free, {reach.from_mm, reach.to_mm, settings.image_radius_mm}));
  }
  const auto key = mechanics::KeyOf(mesh, settings.elasticity, settings.element);
  mechanics::Condensation condensation(mesh, free, settings.elasticity, settings.element,
                                       std::move(reachable), settings.max_memory_mib, context);
  const auto file =
      mechanics::WriteCompliance(folder / "compliance.acc", condensation, key, mesh.nodes_mm.cols(),
                                 visible, settings.storage, context);
  json report = Report(mesh, free, condensation, file, visible.size());
  report["element"] = key.element;
  report["elasticity"] = std::filesystem::path(settings.elasticity.file).filename().string();
  report["storage"] = settings.storage == mechanics::Storage::kFloat ? "float" : "double";
  report["mesh_sha256"] = key.mesh_sha256;
  report["elasticity_sha256"] = key.elasticity_sha256;
  config::WriteJson(folder / "condensation.json", report);
}

}  // namespace acus::meshing
