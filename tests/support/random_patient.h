// A patient on disk with all that effects may ask for, and random scenarios of it that the schema
// allows.
#pragma once

#include <cstdlib>
#include <filesystem>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/physics/breathing/motion_file.h"
#include "support/breathing_box.h"
#include "support/layered_scene.h"
#include "support/schema_sampler.h"

namespace acus::testing_support {

/// Writes the layered patient, a corridor and four motion models into `folder`. Presets come from
/// the source tree from then on.
inline void WriteRandomPatient(const std::filesystem::path& folder) {
  namespace fs = std::filesystem;
  setenv("ACUS_CONFIGS", (fs::path(ACUS_SOURCE_DIR) / "configs").c_str(), 1);
  const simulation::Scene scene = LayeredScene(PlanOf(true, true, true, true), true);
  volume::WriteCt(folder / "ct.nrrd", *scene.ct);
  volume::WriteLabelMap(folder / "labels.seg.nrrd", *scene.labels);
  WriteTextFile(folder / "corridor.csv", "name,x_mm,y_mm,z_mm\nentry,0,0,0\ntarget,0,0,50\n");
  for (const char* kind : {"sinusoid", "full_cycle", "half_cycle", "surrogate"}) {
    breathing::PatientMotion motion{
        .name = kind, .model = breathing::BuildModel(breathing::MotionKindOf(kind), TruePhases(8))};
    fs::create_directories(folder / kind);
    breathing::WritePatientMotion(folder / kind, motion);
  }
}

/// Of the scenario's schema, with what of the patient is in the folder.
inline SchemaSampler ScenarioSampler() {
  using nlohmann::json;
  SchemaSampler::Choices choices = {
      {"/patient",
       {{{"ct", "ct.nrrd"}, {"labels", "labels.seg.nrrd"}, {"corridor", "corridor.csv"}}}},
      {"/session", {}},
      {"/evidence", {}},
      {"/needle", {"needles/spinal_22g.json", "needles/bevel_22g.json", "needles/trocar_18g.json"}},
      {"/probe", {"probes/linear_l14.json", "probes/curvilinear_c5.json"}},
      // Needs a condensed mesh, which has hard cases of its own.
      {"/effects/tissue/model", {"displacement_functions", "springs", "fe_2d"}},
      {"/effects/breathing/motion", {"sinusoid", "full_cycle", "half_cycle", "surrogate"}},
      {"/effects/breathing/from_session", {}},
      {"/effects/breathing/hold", {json::array(), {{1.0, 2.5}}}},
      // A film; its images have tests of their own.
      {"/effects/view_3d", {}},
      {"/effects/pulsating_vessels/centrelines", {}},
      {"/effects/pulsating_vessels/tissue", {"vessel", "liver", "bone"}},
      {"/effects/peristalsis/centrelines", {}},
      {"/effects/peristalsis/tissue", {"vessel", "liver", "bone"}},
      {"/effects/fluid/syringe", {"lor_plastic_10ml", "plastic_2ml"}},
      {"/effects/fluid/filling_ml", {0.0, 1.5}},
      {"/effects/fluid/gauge", {18}},
      {"/effects/fluid/bore", {"regular", "tuohy"}},
      {"/effects/fluid/epidural", {"epidural_lumbar"}},
      {"/effects/fluid/subarachnoid", {"spinal_canal"}},
      {"/effects/fluid/vessel", {"vein", "artery"}},
      {"/effects/fluid/tissues", {json::object(), {{"lesion", "cyst"}}}},
      {"/effects/fluid/space", {"", "cyst"}},
      {"/effects/pain_reaction/tissues", {{"skin"}, {"skin", "liver", "bone"}, json::array()}}};
  return {scenario::ScenarioSchema(), choices};
}

/// Keeps the rules between effects, which are not in the schema: what they forbid is tested where
/// they are checked, and would here only waste most of the draws.
inline nlohmann::json Mended(nlohmann::json document) {
  using nlohmann::json;
  json& effects = document["effects"];
  const auto model_of = [&effects](const char* effect) {
    return effects.contains(effect) ? effects[effect].value("model", "") : std::string();
  };
  if (effects.contains("needle") || effects.contains("fluid") ||
      model_of("tissue") == "displacement_functions") {
    effects.emplace("needle_force", json::object());
  }
  if (model_of("needle_force") == "tissue" && model_of("tissue") != "springs" &&
      model_of("tissue") != "fe_2d") {
    effects["needle_force"].erase("model");
  }
  if (effects.contains("needle") || model_of("needle_force") == "tissue") {
    if (effects.contains("needle_force")) effects["needle_force"].erase("guidance");
  }
  if (model_of("probe_force") == "tissue") effects["probe_force"].erase("model");
  if (model_of("needle") == "bendable") effects["needle"].erase("axis_lock");
  if (effects.empty()) effects["ct_slice"] = json::object();
  return document;
}

}  // namespace acus::testing_support
