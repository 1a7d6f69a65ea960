// Which knobs there are. Defaults are not said here: they are read from the schema.
#include <algorithm>
#include <initializer_list>
#include <utility>

#include "acus/assess/tuning/knob.h"
#include "acus/base/core/error.h"
#include "acus/imaging/acoustics/probe.h"

namespace acus::tuning {
namespace {

using nlohmann::json;
using scenario::Scenario;

/// What the schema fills in at a place; null if it must be given.
json SchemaDefault(const json& schema, const std::string& pointer) {
  const json* node = &schema;
  json::json_pointer place(pointer);
  std::vector<std::string> keys;
  for (; !place.empty(); place.pop_back()) keys.push_back(place.back());
  for (auto key = keys.rbegin(); key != keys.rend(); ++key) node = &node->at("properties").at(*key);
  return node->value("default", json());
}

/// Collects the knobs of a scenario, with what the schema and the scenario say of each.
class Table {
 public:
  explicit Table(const Scenario& scenario) : scenario_(scenario) {}

  /// A knob with one place in the scenario.
  Knob& Add(const char* name, const char* title, const char* unit, const std::string& pointer,
            ActsOn acts_on, std::vector<json> levels) {
    Knob knob;
    knob.name = name;
    knob.title = title;
    knob.unit = unit;
    knob.acts_on = acts_on;
    knob.levels = std::move(levels);
    if (!pointer.empty()) {
      knob.pointers = {pointer};
      knob.default_value = SchemaDefault(schema_, pointer);
      const json::json_pointer place(pointer);
      if (scenario_.effective.contains(place)) {
        knob.scenario_value = scenario_.effective.at(place);
      }
    }
    const bool numbers = knob.levels.size() >= 2 && knob.levels.front().is_number();
    knob.falls = numbers && knob.levels.front() > knob.levels.back();
    knobs_.push_back(std::move(knob));
    return knobs_.back();
  }

  std::vector<Knob> Take() { return std::move(knobs_); }

 private:
  const Scenario& scenario_;
  const json schema_ = scenario::ScenarioSchema();
  std::vector<Knob> knobs_;
};

void AddTissue(const Scenario& s, Table& table) {
  using scenario::TissueModelKind;
  const std::string effect = "/effects/tissue";
  Knob& model = table.Add("tissue_model", "model of the tissue that tools deform", "",
                          effect + "/model", ActsOn::kBoth, {});
  model.levels = {"displacement_functions", "springs", "fe_2d", "fe_3d"};
  model.papers = {{"displacement_functions", "Alamilla-2021"},
                  {"springs", "Fortmeier-2016"},
                  {"fe_2d", "Augmented-2010"}};
  switch (s.tissue->model) {
    case TissueModelKind::kSprings:
      table.Add("spring_path_spacing_mm", "nodes of the path that hold the needle by springs", "mm",
                effect + "/springs/path_spacing_mm", ActsOn::kBoth, {8, 4, 2, 1, 0.5});
      break;
    case TissueModelKind::kPlane2010:
      // 19 x 19 nodes over a plane of 90 mm are the 361 of the mesh that the paper names.
      table
          .Add("fe_2d_spacing_mm", "nodes of the plane of finite elements", "mm",
               effect + "/fe_2d/spacing_mm", ActsOn::kBoth, {8, 5, 3, 2, 1.5})
          .papers = {{5, "361 nodes, Augmented-2010"}};
      break;
    case TissueModelKind::kFem3d: {
      table.Add("contact_spacing_mm", "points along the needle that touch the finite elements",
                "mm", effect + "/fe_3d/contact_spacing_mm", ActsOn::kBoth, {8, 4, 3, 2, 1.5, 1});
      Knob& mesh = table.Add("mesh", "mesh of the tissue", "", "/patient/mesh", ActsOn::kBoth, {});
      mesh.is_folder = true;
      mesh.scenario_value = s.patient.mesh.string();
      break;
    }
    case TissueModelKind::kDisplacementFunctions:
      break;
  }
  if (s.tissue->image && (s.ultrasound || s.ct_slice)) {
    table.Add("tissue_warp_spacing_mm", "knots at which images evaluate the tissue's motion", "mm",
              effect + "/warp_spacing_mm", ActsOn::kImage, {16, 8, 4, 2, 1, 0.5});
    table.Add("tissue_inverse_iterations", "iterations to find where a knot was at rest", "",
              effect + "/inverse_iterations", ActsOn::kImage, {1, 2, 4, 8, 12, 24});
  }
}

void AddNeedle(const Scenario& s, Table& table) {
  const std::string effect = "/effects/needle";
  Knob& model = table.Add("needle_model", "shape of the needle", "", effect + "/model",
                          ActsOn::kBoth, {"rigid", "lateral_beam", "bendable"});
  model.papers = {{"lateral_beam", "Augmented-2010"}, {"bendable", "Fortmeier-2016"}};
  if (s.shape->model != scenario::NeedleModelKind::kBendable) return;
  table
      .Add("needle_nodes", "nodes of the bendable needle", "", effect + "/nodes", ActsOn::kBoth,
           {8, 15, 25, 50, 100})
      .papers = {{25, "Fortmeier-2016, table 1"},
                 {15, "Fortmeier-2016, figure 13"},
                 {50, "Fortmeier-2016, figure 13"}};
  table.Add("needle_path_spacing_mm", "nodes of the path that the bendable needle has cut", "mm",
            effect + "/path_spacing_mm", ActsOn::kBoth, {8, 4, 2, 1, 0.5});
}

void AddForces(const Scenario& s, double recorded_rate_hz, Table& table) {
  if (s.needle_force) {
    Knob& model = table.Add("force_model", "law of the force on the needle", "",
                            "/effects/needle_force/model", ActsOn::kForce,
                            {"vidal", "layered", "alamilla", "tissue"});
    model.papers = {{"vidal", "Vidal-2008"}, {"alamilla", "Alamilla-2021"}};
  }
  if (s.probe_force) {
    const std::string effect = "/effects/probe_force";
    table
        .Add("probe_force_model", "law of the force on the probe", "", effect + "/model",
             ActsOn::kForce, {"vidal", "multi_proxy"})
        .papers = {{"vidal", "Vidal-2008, section 3.3.1"},
                   {"multi_proxy", "Fortmeier-2016, palpation"}};
    if (s.probe_force->model == scenario::ProbeForceModelKind::kMultiProxy) {
      table.Add("probe_proxies", "proxies on the face of the probe", "",
                effect + "/multi_proxy/proxies", ActsOn::kForce, {1, 4, 8, 16, 32, 64});
    }
  }
  const bool steps = s.needle_force || s.probe_force || (s.tissue && s.tissue->TouchesNeedle());
  if (steps && recorded_rate_hz > 0.0) {
    Knob& rate = table.Add("step_rate_hz", "steps per second", "Hz", "", ActsOn::kForce,
                           {500, 1000, 2000, 4000});
    rate.scenario_value = recorded_rate_hz;
    rate.papers = {{1000, "Augmented-2010; Vidal-2008"}, {2000, "Fortmeier-2016"}};
  }
}

void AddBreathing(const Scenario& s, Table& table) {
  const std::string effect = "/effects/breathing";
  Knob& motion = table.Add("motion", "motion of the breathing patient: model and resolution", "",
                           effect + "/motion", ActsOn::kBoth, {});
  motion.is_folder = true;
  motion.scenario_value = s.breathing->motion.string();
  if (!s.breathing->image || !(s.ultrasound || s.ct_slice)) return;
  table.Add("breathing_warp_spacing_mm", "knots at which images evaluate the patient's breath",
            "mm", effect + "/warp_spacing_mm", ActsOn::kImage, {20, 10, 5, 2, 1});
  table
      .Add("breathing_inverse_iterations", "iterations to find where a knot was at rest", "",
           effect + "/inverse_iterations", ActsOn::kImage, {1, 2, 3, 5, 10, 50})
      .papers = {{5, "Fortmeier-2016, figure 11"}, {50, "Fortmeier-2016, figure 11"}};
}

void AddBeams(Table& table) {
  const std::string effect = "/effects/ultrasound/beams/";
  const std::vector<json> off_on = {false, true};
  const std::pair<const char*, const char*> parts[] = {
      {"angle", "echoes that depend on the angle of the interface"},
      {"speckle", "scatterers fixed in the tissue"},
      {"fibre_texture", "speckle that is longer along fibres"},
      {"point_spread", "pulse and beam of the probe"},
      {"comet_tail", "ring-down behind gas and within the needle"},
      {"refraction", "lines that bend by Snell's law"},
      {"time_of_flight", "samples at their time, by the local speed of sound"},
      {"multiple_reflections", "echoes between interfaces and the face"}};
  for (const auto& [name, title] : parts) {
    table.Add(name, title, "", effect + name, ActsOn::kImage, off_on);
  }
  table.Add("elevation_planes", "planes over the thickness of the slice", "",
            effect + "elevation_planes", ActsOn::kImage, {1, 3, 5, 7, 11, 15});
}

void AddAperture(Table& table) {
  const std::string effect = "/effects/ultrasound/aperture/";
  const std::vector<json> off_on = {false, true};
  const std::pair<const char*, const char*> parts[] = {
      {"angle", "echoes that depend on the angle of the interface"},
      {"speckle", "scatterers fixed in the tissue"},
      {"texture", "scatterers that follow the CT"},
      {"point_spread", "pulse and beam of the probe"},
      {"reverberation", "echoes that go to the face and back again"},
      {"refraction", "rays of the aperture that bend with the speed of sound"},
      {"side_lobes", "side lobes and grating lobes"},
      {"fibre_texture", "streaks of muscle"},
      {"clutter", "haze of nearby echoes"},
      {"noise", "noise of the receiver"}};
  for (const auto& [name, title] : parts) {
    table.Add(name, title, "", effect + name, ActsOn::kImage, off_on);
  }
  table.Add("elevation_planes", "planes over the thickness of the slice", "",
            effect + "elevation_planes", ActsOn::kImage, {1, 3, 5, 7, 11, 15});
  table.Add("aperture_rays", "directions over the aperture", "", effect + "aperture_rays",
            ActsOn::kImage, {1, 3, 5, 9, 13, 21, 31});
}

/// Lines and samples of each, which the probe preset has unless the scenario says otherwise.
void AddLines(const Scenario& s, Table& table) {
  const acoustics::Probe probe = acoustics::ReadProbe(s.probe);
  const bool is_beams = s.ultrasound->InBeamSpace();
  const bool is_fan = s.ultrasound->model == scenario::UltrasoundModel::kColumns2010 &&
                      probe.kind != acoustics::ProbeKind::kLinear;
  const auto add = [&table](const char* name, const char* title, const std::string& key,
                            std::vector<json> levels, int preset, int scenario) {
    Knob& knob =
        table.Add(name, title, "", "/effects/ultrasound/" + key, ActsOn::kImage, std::move(levels));
    knob.default_value = preset;
    knob.scenario_value = scenario > 0 ? scenario : preset;
  };
  if (is_beams || is_fan) {
    add("image_lines", "scan lines of the image", "scan_lines", {64, 128, 192, 256, 384, 512},
        probe.scan_lines, s.ultrasound->scan_lines);
  }
  if (is_beams) {
    add("image_samples", "samples of each scan line", "samples_per_line",
        {256, 512, 1024, 2048, 4096}, probe.samples_per_line, s.ultrasound->samples_per_line);
  }
}

void AddUltrasound(const Scenario& s, Table& table) {
  Knob& model = table.Add("ultrasound_model", "what makes the B-mode image", "",
                          "/effects/ultrasound/model", ActsOn::kImage,
                          {"vidal_2008", "alamilla_2021", "columns_2010", "beams", "aperture"});
  model.papers = {{"vidal_2008", "Vidal-2008"},
                  {"alamilla_2021", "Alamilla-2021"},
                  {"columns_2010", "Augmented-2010"}};
  AddLines(s, table);
  if (s.ultrasound->model == scenario::UltrasoundModel::kBeams) AddBeams(table);
  if (s.ultrasound->model == scenario::UltrasoundModel::kAperture) AddAperture(table);
}

}  // namespace

std::vector<Knob> KnobsOf(const Scenario& scenario, double recorded_rate_hz) {
  Table table(scenario);
  if (scenario.tissue) AddTissue(scenario, table);
  if (scenario.shape) AddNeedle(scenario, table);
  AddForces(scenario, recorded_rate_hz, table);
  if (scenario.breathing) AddBreathing(scenario, table);
  if (scenario.ultrasound) AddUltrasound(scenario, table);
  for (const effects::CalledEffect& other : scenario.listed) {
    for (const effects::Knob& knob : other.effect->Knobs()) {
      table.Add(knob.name.c_str(), knob.title.c_str(), knob.unit.c_str(),
                Message("/effects/", other.effect->key(), "/", knob.key), knob.acts_on,
                knob.levels);
    }
  }
  return table.Take();
}

}  // namespace acus::tuning
