// A patient on disk with all that any effect can ask for, and every effect in each of its models.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/data/mesh/surface_io.h"
#include "acus/data/volume/volume_io.h"
#include "acus/physics/breathing/motion_file.h"
#include "acus/physics/mechanics/condensation/compliance_file.h"
#include "acus/physics/mechanics/condensation/reachable.h"
#include "support/box_mesh.h"
#include "support/breathing_box.h"
#include "support/layered_scene.h"
#include "support/temporary_folder.h"

namespace acus::testing_support {

/// An effect of a scenario in one of its models, with the other effects that it cannot be without.
struct EffectChoice {
  std::string effect;
  std::string name;  ///< "tissue springs"
  nlohmann::json effects;
};

/// Every effect of the schema in every model, cheap settings throughout.
inline std::vector<EffectChoice> AllEffectChoices() {
  using Json = nlohmann::json;
  std::vector<EffectChoice> all;
  const auto add = [&all](const std::string& effect, const std::string& model, const Json& settings,
                          Json others = Json::object()) {
    others[effect] = settings;
    all.push_back({effect, effect + (model.empty() ? "" : " " + model), others});
  };
  const Json layered = {{"model", "layered"}};
  const Json springs = {{"model", "springs"}};
  add("needle_force", "layered", layered);
  add("needle_force", "alamilla", {{"model", "alamilla"}, {"table", "forces/alamilla.json"}});
  add("needle_force", "vidal", {{"model", "vidal"}, {"table", "forces/vidal.json"}});
  add("needle_force", "tissue", {{"model", "tissue"}}, {{"tissue", springs}});
  for (const char* model : {"rigid", "lateral_beam", "bendable"}) {
    add("needle", model, {{"model", model}}, {{"needle_force", layered}});
  }
  add("needle", "bendable in a mesh", {{"model", "bendable"}},
      {{"needle_force", {{"model", "tissue"}}}, {"tissue", {{"model", "fe_3d"}}}});
  add("probe_force", "vidal", {{"model", "vidal"}});
  add("probe_force", "multi_proxy", {{"model", "multi_proxy"}});
  add("probe_force", "multi_proxy by labels",
      {{"model", "multi_proxy"}, {"multi_proxy", {{"reads", "labels"}, {"tool", "fingertip"}}}});
  add("tissue", "displacement_functions", {{"model", "displacement_functions"}},
      {{"needle_force", layered}});
  add("tissue", "displacement_functions as printed",
      {{"model", "displacement_functions"}, {"displacement_functions", {{"form", "printed"}}}},
      {{"needle_force", layered}});
  add("tissue", "springs", springs);
  add("tissue", "fe_2d",
      {{"model", "fe_2d"}, {"fe_2d", {{"spacing_mm", 5}, {"width_mm", 40}, {"beyond_mm", 10}}}});
  add("tissue", "fe_3d", {{"model", "fe_3d"}});
  add("tissue", "fe_3d pressed", {{"model", "fe_3d"}, {"fe_3d", {{"probe_contact", true}}}});
  for (const char* motion : {"sinusoid", "full_cycle", "half_cycle", "surrogate"}) {
    add("breathing", motion, {{"motion", motion}});
  }
  add("ultrasound", "columns_2010", Json::object());
  for (const char* model : {"vidal_2008", "alamilla_2021", "beams", "aperture"}) {
    add("ultrasound", model, {{"model", model}});
  }
  add("ultrasound", "beams by ct", {{"model", "beams"}, {"beams", {{"volume", "ct"}}}});
  add("ct_slice", "", Json::object());
  add("fluoroscopy", "", Json::object());
  const Json small = {{"width_px", 48}, {"height_px", 36}, {"surface_grid_mm", 4}};
  Json surfaces = small;
  surfaces["surfaces"] = Json::array({{{"tissue", "skin"}}});
  surfaces["layers"] = Json::array();
  surfaces["force_arrow_mm_per_n"] = 10;
  add("view_3d", "surfaces", surfaces);
  Json layers = small;
  layers["surfaces"] = Json::array();
  layers["layers"] = Json::array({{{"preset", "bone"}}});
  add("view_3d", "layers", layers);
  Json maximum = small;
  maximum["surfaces"] = Json::array();
  maximum["projection"] = "maximum";
  add("view_3d", "maximum", maximum);
  add("planes", "",
      {{"width_px", 48},
       {"height_px", 32},
       {"mm_per_px", 2},
       {"thickness_mm", 4},
       {"slab", "maximum"}});
  add("pulsating_vessels", "",
      {{"centrelines", "vessels.csv"}, {"radial_strain", 0.2}, {"reach_mm", 20}});
  add("peristalsis", "", {{"centrelines", "vessels.csv"}, {"contraction", 0.4}});
  add("fluid", "", {{"thumb", "continuous"}, {"presses_from", "skin"}},
      {{"needle_force", layered}});
  add("pain_reaction", "", {{"tissues", {"skin", "muscle"}}, {"latency_s", 0.0}});
  return all;
}

/// True if two lists of effects ask for the same where both ask for it.
inline bool Agree(const nlohmann::json& a, const nlohmann::json& b) {
  for (const auto& [effect, settings] : b.items()) {
    if (a.contains(effect) && a[effect] != settings) return false;
  }
  return true;
}

class EffectsPatient {
 public:
  explicit EffectsPatient(const volume::Geometry& geometry = LayeredGeometry()) {
    setenv("ACUS_CONFIGS", (std::filesystem::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
    const auto scene = LayeredScene(PlanOf(true, true, true, true), true, geometry);
    volume::WriteCt(folder() / "ct.nrrd", *scene.ct);
    volume::WriteLabelMap(folder() / "labels.seg.nrrd", *scene.labels);
    WriteTextFile(folder() / "corridor.csv",
                  "name,x_mm,y_mm,z_mm\nentry,0,-10,0\ntarget,0,-10,50\n");
    // Past the needle's way, as near as an artery should be.
    WriteTextFile(folder() / "vessels.csv",
                  "vessel,x_mm,y_mm,z_mm,radius_mm\na,-40,-4,12,5\na,40,-4,12,5\n");
    for (const char* kind : {"sinusoid", "full_cycle", "half_cycle", "surrogate"}) {
      std::filesystem::create_directories(folder() / kind);
      breathing::WritePatientMotion(
          folder() / kind,
          {.name = kind,
           .model = breathing::BuildModel(breathing::MotionKindOf(kind), TruePhases(8))});
    }
    Condense();
  }

  const std::filesystem::path& folder() const { return temporary_.path(); }

  /// The scenario with these effects.
  scenario::Scenario With(const nlohmann::json& effects) const {
    const nlohmann::json document = {{"format", "acus-scenario/1"},
                                     {"patient",
                                      {{"ct", "ct.nrrd"},
                                       {"labels", "labels.seg.nrrd"},
                                       {"corridor", "corridor.csv"},
                                       {"mesh", "mesh"}}},
                                     {"probe", "probes/linear_l14.json"},
                                     {"effects", effects}};
    config::WriteJson(folder() / "scene.json", document);
    return scenario::ReadScenario(folder() / "scene.json", {});
  }

 private:
  void Condense() const {
    const auto to = folder() / "mesh";
    std::filesystem::create_directories(to);
    mesh::TetraMesh mesh = BoxMesh({8, 8, 9}, {-29.9, -29.9, 0}, {29.9, 29.9, 90});
    std::ranges::fill(mesh.tissue, volume::LabelOf("muscle"));
    Fix(mesh, [](const Eigen::Vector3d& x) { return x.z() > 89.0; });
    mesh::WriteTetraMesh(to / "mesh.vtu", mesh);
    const mesh::TetraMesh read = mesh::ReadTetraMesh(to / "mesh.vtu");
    const auto elasticity = mechanics::ReadElasticityTable(std::filesystem::path(ACUS_SOURCE_DIR) /
                                                           "configs/elasticity/default.json");
    constexpr auto kElement = mechanics::ElementKind::kAveragedDilatation;
    const mechanics::FreeNodes free = mechanics::FindFreeNodes(read);
    const mechanics::Capsule corridor{{0, -10, 0}, {0, -10, 50}, 6.0};
    mechanics::Condensation condensation(read, free, elasticity, kElement,
                                         mechanics::CorridorNodes(read, free, corridor),
                                         mechanics::kDefaultMemoryMib, RunContext());
    mechanics::WriteCompliance(
        to / "compliance.acc", condensation, mechanics::KeyOf(read, elasticity, kElement),
        read.nodes_mm.cols(),
        mechanics::NodesInside(read, free, {corridor.from_mm, corridor.to_mm, 25.0}),
        mechanics::Storage::kDouble, RunContext());
  }

  TemporaryFolder temporary_;
};

}  // namespace acus::testing_support
