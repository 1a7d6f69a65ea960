#include "simulation/effect_plan.h"

#include <algorithm>
#include <set>

#include "core/error.h"

namespace acus::simulation {
namespace {

using scenario::Scenario;
using Names = std::vector<std::string_view>;

bool FromTissue(const Scenario& s) {
  return s.needle_force && s.needle_force->model == scenario::NeedleForceModelKind::kTissue;
}

/// What the force on the needle is computed from. The CT itself tells Vidal's model what it meets;
/// tissues are looked up for the log.
Names ForceInputs(const Scenario& s) {
  if (FromTissue(s)) return {"contact"};
  Names reads{"needle", "tissue", "force table"};
  if (s.needle_force && s.needle_force->model == scenario::NeedleForceModelKind::kVidal) {
    reads.push_back("ct");
  }
  return reads;
}

/// What tissue under a tool is computed from, besides the tool.
Names TissueInputs(const Scenario& s) {
  if (!s.tissue) return {};
  Names reads{"needle", "elasticity"};
  switch (s.tissue->model) {
    case scenario::TissueModelKind::kDisplacementFunctions:
    case scenario::TissueModelKind::kSprings:
      reads.push_back("labels");
      break;
    case scenario::TissueModelKind::kPlane2010:
      reads.insert(reads.end(), {"labels", "corridor"});
      break;
    case scenario::TissueModelKind::kFem3d:
      reads.push_back("mesh");
      break;
  }
  if (s.tissue->TouchesNeedle()) reads.push_back("force table");
  if (s.tissue->probe_contact) reads.insert(reads.end(), {"probe poses", "probe"});
  return reads;
}

/// True if the images show tissue elsewhere than the CT does.
bool ShowsDeformation(const Scenario& s) {
  return (s.tissue && s.tissue->image) || (s.breathing && s.breathing->image);
}

/// What the force on the probe is computed from, at every sample.
Names ProbeForceInputs(const Scenario& s) {
  if (!s.probe_force) return {};
  Names reads{"probe poses", "force table", s.probe_force->reads_labels ? "labels" : "ct"};
  if (s.probe_force->NeedsProbePreset()) reads.push_back("probe preset");
  if (s.breathing) reads.push_back("breath");
  return reads;
}

/// What an image reads besides the patient: the probe, the needle and the deformation if they show.
Names ImageInputs(const Scenario& s, bool needle, Names patient) {
  Names reads = std::move(patient);
  reads.push_back("probe");
  if (needle) reads.push_back("needle");
  if (needle && s.shape) reads.push_back("shape");
  if (ShowsDeformation(s)) reads.push_back("rest map");
  return reads;
}

/// What the needle's shape comes from: the path that the force model knows, and the tissue on it.
Names ShapeInputs(const Scenario& s) {
  Names reads{"needle", "force"};
  if (s.shape && s.shape->model == scenario::NeedleModelKind::kBendable) {
    reads.insert(reads.end(), {FromTissue(s) ? "contact" : "tissue", "elasticity"});
  }
  return reads;
}

Names UltrasoundInputs(const Scenario& s) {
  if (!s.ultrasound) return {};
  Names patient;
  if (s.ultrasound->ReadsCt()) patient.push_back("ct");
  if (s.ultrasound->ReadsLabels()) patient.push_back("labels");
  return ImageInputs(s, s.ultrasound->needle, std::move(patient));
}

Names FluoroscopyInputs(const Scenario& s) {
  Names reads{"ct"};
  if (s.fluoroscopy && s.fluoroscopy->needle) reads.push_back("needle");
  if (s.fluoroscopy && s.fluoroscopy->needle && s.shape) reads.push_back("shape");
  if (ShowsDeformation(s)) reads.push_back("rest map");
  return reads;
}

/// What the deformation in the images comes from.
Names DeformationInputs(const Scenario& s) {
  Names reads;
  if (s.tissue && s.tissue->image) {
    reads = s.tissue->TouchesNeedle() ? Names{"contact"} : Names{"force", "labels", "elasticity"};
  }
  if (s.breathing && s.breathing->image) reads.push_back("breath");
  return reads;
}

/// What the view in three dimensions shows.
Names ViewInputs(const Scenario& s) {
  if (!s.view_3d) return {};
  Names reads;
  if (!s.view_3d->layers.empty()) reads.push_back("ct");
  if (!s.view_3d->surfaces.empty()) reads.push_back("labels");
  if (s.view_3d->needle) reads.push_back("needle");
  if (s.view_3d->needle && s.shape) reads.push_back("shape");
  if (s.view_3d->probe) reads.push_back("probe");
  if (s.view_3d->probe && s.view_3d->picture && s.ultrasound) reads.push_back("B-mode picture");
  if (s.breathing && s.breathing->image) reads.push_back("breath");
  return reads;
}

Names BreathingInputs(const Scenario& s) {
  if (!s.breathing || s.breathing->from_session != scenario::SessionBreath::kAlways) {
    return {"motion"};
  }
  return {"motion", "session's breath"};
}

/// All stages that there are, in the order in which they run.
std::vector<PlannedStage> DeclaredStages(const Scenario& s) {
  const auto step = [](StageId id, std::string_view name, Names reads, Names writes) {
    return PlannedStage{id, name, "step", std::move(reads), std::move(writes), false, ""};
  };
  const auto image = [](StageId id, std::string_view name, Names reads, Names writes) {
    return PlannedStage{id, name, "image", std::move(reads), std::move(writes), false, ""};
  };
  return {
      step(StageId::kBreathing, "breathing", BreathingInputs(s), {"breath"}),
      step(StageId::kNeedlePose, "needle pose",
           s.breathing ? Names{"needle poses", "breath"} : Names{"needle poses"}, {"needle"}),
      // Without a label map, from the HU of the CT.
      step(StageId::kTissueLookup, "tissue lookup",
           {"needle", s.patient.labels.empty() && !s.patient.ct.empty() ? "ct" : "labels"},
           {"tissue"}),
      step(StageId::kTissueContact, "tissue contact", TissueInputs(s), {"contact"}),
      step(StageId::kNeedleForce, "needle force", ForceInputs(s), {"force"}),
      step(StageId::kNeedleShape, "needle shape", ShapeInputs(s), {"shape"}),
      step(StageId::kProbeForce, "probe force", ProbeForceInputs(s), {"probe force"}),
      image(StageId::kProbePose, "probe pose", {"probe poses"}, {"probe"}),
      image(StageId::kDeformation, "deformation", DeformationInputs(s), {"rest map"}),
      image(StageId::kCtSlice, "CT slice", ImageInputs(s, s.ct_slice && s.ct_slice->needle, {"ct"}),
            {"CT picture"}),
      image(StageId::kUltrasound, "B-mode", UltrasoundInputs(s), {"B-mode picture"}),
      image(StageId::kFluoroscopy, "fluoroscopy", FluoroscopyInputs(s), {"fluoroscopy picture"}),
      image(StageId::kView3d, "view in 3D", ViewInputs(s), {"view"}),
  };
}

/// What a stage produces that no other stage reads: it is there for an effect's sake.
struct Goal {
  StageId stage;
  std::string effect;
};

std::vector<Goal> Goals(const Scenario& s) {
  std::vector<Goal> goals;
  if (s.needle_force) goals.push_back({StageId::kNeedleForce, "needle_force"});
  if (s.shape) goals.push_back({StageId::kNeedleShape, "needle"});
  if (s.probe_force) goals.push_back({StageId::kProbeForce, "probe_force"});
  if (s.tissue && s.tissue->TouchesNeedle()) goals.push_back({StageId::kTissueContact, "tissue"});
  if (s.ct_slice) goals.push_back({StageId::kCtSlice, "ct_slice"});
  if (s.ultrasound) goals.push_back({StageId::kUltrasound, "ultrasound"});
  if (s.fluoroscopy) goals.push_back({StageId::kFluoroscopy, "fluoroscopy"});
  if (s.view_3d) goals.push_back({StageId::kView3d, "view_3d"});
  return goals;
}

/// Inputs from outside and what to do when one is missing.
struct Input {
  std::string_view name;
  bool there;
  const char* remedy;
};

std::vector<Input> Inputs(const Scenario& s, const AvailableInputs& available) {
  return {
      {"needle poses", available.needle_poses, "the session has no needle stream"},
      {"probe poses", available.probe_poses, "the session has no probe stream"},
      {"ct", !s.patient.ct.empty() || !s.patient.surfaces.empty(), "/patient/ct is not given"},
      {"labels", !s.patient.labels.empty() || !s.patient.surfaces.empty(),
       "/patient/labels is not given"},
      {"mesh", !s.patient.mesh.empty(),
       "/patient/mesh is not given; acus-mesh --condense makes one"},
      {"corridor", !s.patient.corridor.empty(),
       "/patient/corridor is not given: a CSV with the points entry and target"},
      {"motion", true, ""},
      {"session's breath", available.breath,
       "the session has no breathing stream; /effects/breathing/from_session \"if_recorded\" would "
       "take the scenario's"},
      {"force table", true, ""},
      {"elasticity", true, ""},
      {"probe preset", true, ""},
  };
}

}  // namespace

bool EffectPlan::Has(StageId id) const {
  return std::ranges::any_of(stages_, [id](const auto& s) { return s.id == id && s.in; });
}

bool EffectPlan::Needs(std::string_view data) const {
  return std::ranges::any_of(stages_, [data](const auto& s) {
    return s.in && std::ranges::find(s.reads, data) != s.reads.end();
  });
}

EffectPlan PlanEffects(const Scenario& scenario, const AvailableInputs& available) {
  EffectPlan plan;
  plan.stages_ = DeclaredStages(scenario);
  plan.breath_from_session_ = scenario.breathing && available.breath &&
                              scenario.breathing->from_session != scenario::SessionBreath::kNever;
  auto& stages = plan.stages_;
  for (const Goal& goal : Goals(scenario)) {
    auto& stage = *std::ranges::find(stages, goal.stage, &PlannedStage::id);
    stage.in = true;
    stage.reason = "effect " + goal.effect + " is called for";
  }
  // Backwards: a stage is in if one behind it reads what it writes.
  for (auto reader = stages.rbegin(); reader != stages.rend(); ++reader) {
    if (!reader->in) continue;
    for (auto& writer : stages) {
      const bool feeds =
          std::ranges::find_first_of(writer.writes, reader->reads) != writer.writes.end();
      if (!feeds || writer.in) continue;
      writer.in = true;
      writer.reason = Message("needed by ", reader->name);
    }
  }
  const auto inputs = Inputs(scenario, available);
  std::string missing;
  for (auto& stage : stages) {
    if (!stage.in) stage.reason = "no effect of the scenario needs it";
    if (!stage.in) continue;
    for (const auto& input : inputs) {
      if (input.there || std::ranges::find(stage.reads, input.name) == stage.reads.end()) continue;
      missing += Message("\n  ", stage.name, " (", stage.reason, ") needs ", input.name, ": ",
                         input.remedy);
    }
  }
  ACUS_REQUIRE(missing.empty(), scenario.file.string(), ": effects lack inputs:", missing,
               "\nGive the input, or take the effect out of the scenario (--set "
               "/effects/NAME=null).");
  return plan;
}

}  // namespace acus::simulation
