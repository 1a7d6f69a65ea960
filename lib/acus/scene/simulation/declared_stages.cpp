#include "acus/scene/simulation/declared_stages.h"

#include "acus/base/core/error.h"

namespace acus::simulation {
namespace {

namespace fs = std::filesystem;
using scenario::Scenario;
using Names = std::vector<std::string_view>;

void Add(Names& names, const Names& more) {
  names.insert(names.end(), more.begin(), more.end());
}

bool FromTissue(const Scenario& s) {
  return s.needle_force && s.needle_force->model == scenario::NeedleForceModelKind::kTissue;
}

/// True if the images show tissue elsewhere than the CT does.
bool ShowsDeformation(const Scenario& s) {
  return (s.tissue && s.tissue->image) || (s.breathing && s.breathing->image);
}

/// A recorded signal is only read where the session does not say how the patient breathes.
Names BreathingInputs(const Scenario& s, bool from_session) {
  if (!s.breathing) return {};
  if (from_session || s.breathing->from_session == scenario::SessionBreath::kAlways) {
    return {"motion", "session's breath"};
  }
  if (s.breathing->signal.empty()) return {"motion"};
  return {"motion", "breath signal"};
}

/// A needle in a patient who breathes lies elsewhere in the CT.
Names NeedlePoseInputs(const Scenario& s) {
  return s.breathing ? Names{"needle poses", "breath"} : Names{"needle poses"};
}

/// Without a label map tissues are told by the HU of the CT, as the force table says.
bool TissuesByHu(const Scenario& s) {
  return s.patient.labels.empty() && !s.patient.ct.empty();
}

Names TissueLookupInputs(const Scenario& s) {
  return TissuesByHu(s) ? Names{"needle", "ct", "force table"} : Names{"needle", "labels"};
}

/// What tissue under a tool is computed from, besides the tool.
Names TissueStageInputs(const Scenario& s) {
  if (!s.tissue) return {};
  Names reads{"needle", "needle preset", "tissue's elasticity", "tissue's force table"};
  switch (s.tissue->model) {
    case scenario::TissueModelKind::kDisplacementFunctions:
      return {};  // Nothing that steps: see DeformationInputs.
    case scenario::TissueModelKind::kSprings:
      Add(reads, {"labels"});
      break;
    case scenario::TissueModelKind::kPlane2010:
      Add(reads, {"labels", "corridor"});
      break;
    case scenario::TissueModelKind::kFem3d:
      Add(reads, {"mesh"});
      if (s.tissue->probe_contact) Add(reads, {"probe poses", "probe preset"});
      break;
  }
  if (s.tissue->probe_contact && s.breathing) Add(reads, {"breath"});
  return reads;
}

/// What the force on the needle is computed from. The CT itself tells Vidal's model what it meets;
/// tissues are looked up for the log.
Names ForceInputs(const Scenario& s) {
  if (!s.needle_force) return {};
  if (FromTissue(s)) return {"contact"};
  Names reads{"needle", "tissue", "needle preset", "force table"};
  if (s.needle_force->model == scenario::NeedleForceModelKind::kVidal) Add(reads, {"ct"});
  return reads;
}

/// What the needle's shape comes from: the path that the force model knows, and the tissue on it.
Names ShapeInputs(const Scenario& s) {
  if (!s.shape) return {};
  Names reads{"needle", "force", "needle preset",
              FromTissue(s) ? "tissue's force table" : "force table"};
  if (s.shape->model != scenario::NeedleModelKind::kBendable) return reads;
  Add(reads, {FromTissue(s) ? "contact" : "tissue", "needle's elasticity"});
  // Which tissues there are; a mesh does not say, and all that can be deformed are taken.
  if (FromTissue(s) ? s.tissue->model != scenario::TissueModelKind::kFem3d : !TissuesByHu(s)) {
    Add(reads, {"labels"});
  }
  if (s.breathing) Add(reads, {"breath"});
  return reads;
}

/// What the force on the probe is computed from, at every sample.
Names ProbeForceInputs(const Scenario& s) {
  if (!s.probe_force) return {};
  Names reads{"probe poses", "probe's force table", s.probe_force->reads_labels ? "labels" : "ct"};
  if (s.probe_force->NeedsProbePreset()) Add(reads, {"probe preset"});
  if (s.breathing) Add(reads, {"breath"});
  return reads;
}

/// What the deformation in the images comes from.
Names DeformationInputs(const Scenario& s) {
  Names reads;
  if (s.tissue && s.tissue->image) {
    reads = s.tissue->TouchesNeedle() ? Names{"contact"}
                                      : Names{"force", "labels", "tissue's elasticity"};
    if (s.tissue->model == scenario::TissueModelKind::kFem3d) reads.push_back("mesh");
  }
  if (s.breathing && s.breathing->image) Add(reads, {"breath"});
  return reads;
}

void AddNeedleInPicture(const Scenario& s, Names& reads) {
  Add(reads, {"needle", "needle preset"});
  if (s.shape) Add(reads, {"shape"});
}

/// What an image reads besides the patient: the probe, the needle and the deformation if they show.
Names ImageInputs(const Scenario& s, bool needle, Names patient) {
  Names reads = std::move(patient);
  Add(reads, {"probe", "probe preset"});
  if (needle) AddNeedleInPicture(s, reads);
  if (ShowsDeformation(s)) Add(reads, {"rest map"});
  return reads;
}

Names CtSliceInputs(const Scenario& s) {
  if (!s.ct_slice) return {};
  return ImageInputs(s, s.ct_slice->needle, {"ct"});
}

Names UltrasoundInputs(const Scenario& s) {
  if (!s.ultrasound) return {};
  Names patient;
  if (s.ultrasound->ReadsCt()) patient.push_back("ct");
  if (s.ultrasound->ReadsLabels()) patient.push_back("labels");
  patient.push_back("acoustics");
  return ImageInputs(s, s.ultrasound->needle, std::move(patient));
}

Names FluoroscopyInputs(const Scenario& s) {
  if (!s.fluoroscopy) return {};
  Names reads{"ct", "C-arm"};
  if (s.fluoroscopy->needle) AddNeedleInPicture(s, reads);
  if (ShowsDeformation(s)) reads.push_back("rest map");
  return reads;
}

/// What the view in three dimensions shows. Of what deforms the patient it shows breath only.
Names ViewInputs(const Scenario& s) {
  if (!s.view_3d) return {};
  Names reads;
  if (!s.view_3d->layers.empty()) reads.push_back("ct");
  if (!s.view_3d->surfaces.empty()) reads.push_back("labels");
  if (s.view_3d->needle) AddNeedleInPicture(s, reads);
  if (s.view_3d->probe) Add(reads, {"probe", "probe preset"});
  if (s.view_3d->ShowsPicture() && s.ultrasound) reads.push_back("B-mode picture");
  if (s.breathing && s.breathing->image) reads.push_back("breath");
  return reads;
}

}  // namespace

std::vector<PlannedStage> DeclaredStages(const Scenario& s, bool breath_from_session) {
  const auto step = [](StageId id, std::string_view name, Names reads, Names writes) {
    return PlannedStage{id, name, "step", std::move(reads), std::move(writes), false, "", {}};
  };
  const auto image = [](StageId id, std::string_view name, Names reads, Names writes) {
    return PlannedStage{id, name, "image", std::move(reads), std::move(writes), false, "", {}};
  };
  return {
      step(StageId::kBreathing, "breathing", BreathingInputs(s, breath_from_session), {"breath"}),
      step(StageId::kNeedlePose, "needle pose", NeedlePoseInputs(s), {"needle"}),
      step(StageId::kTissueLookup, "tissue lookup", TissueLookupInputs(s), {"tissue"}),
      step(StageId::kTissueContact, "tissue contact", TissueStageInputs(s), {"contact"}),
      step(StageId::kNeedleForce, "needle force", ForceInputs(s), {"force"}),
      step(StageId::kNeedleShape, "needle shape", ShapeInputs(s), {"shape"}),
      step(StageId::kProbeForce, "probe force", ProbeForceInputs(s), {"probe force"}),
      image(StageId::kProbePose, "probe pose", {"probe poses"}, {"probe"}),
      image(StageId::kDeformation, "deformation", DeformationInputs(s), {"rest map"}),
      image(StageId::kCtSlice, "CT slice", CtSliceInputs(s), {"CT picture"}),
      image(StageId::kUltrasound, "B-mode", UltrasoundInputs(s), {"B-mode picture"}),
      image(StageId::kFluoroscopy, "fluoroscopy", FluoroscopyInputs(s), {"fluoroscopy picture"}),
      image(StageId::kView3d, "view in 3D", ViewInputs(s), {"view"}),
  };
}

std::vector<Goal> GoalsOf(const Scenario& s) {
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

std::vector<Goal> HelpersOf(const Scenario& s) {
  std::vector<Goal> helpers;
  if (s.breathing) helpers.push_back({StageId::kBreathing, "breathing"});
  if (s.tissue && s.tissue->image) helpers.push_back({StageId::kDeformation, "tissue"});
  if (s.breathing && s.breathing->image) helpers.push_back({StageId::kDeformation, "breathing"});
  return helpers;
}

namespace {

DeclaredInput FromSession(std::string_view name, bool there, const char* remedy) {
  return {{name, {}, ""}, there ? "" : remedy};
}

/// A file of the patient, which the scenario may leave out if nobody reads it.
DeclaredInput OfPatient(std::string_view name, const fs::path& file, const char* remedy) {
  const std::string where = Message("/patient/", name);
  return {{name, file, where}, file.empty() ? Message(where, " is not given", remedy) : ""};
}

/// CT and labels, or the list of surfaces from which both are made.
DeclaredInput Volume(const Scenario& s, std::string_view name, const fs::path& file) {
  if (s.patient.surfaces.empty()) return OfPatient(name, file, "");
  return {{name, s.patient.surfaces, "/patient/surfaces"}, ""};
}

}  // namespace

std::vector<DeclaredInput> DeclaredInputs(const Scenario& s, const AvailableInputs& available) {
  std::vector<DeclaredInput> inputs = {
      FromSession("needle poses", available.needle_poses, "the session has no needle stream"),
      FromSession("probe poses", available.probe_poses, "the session has no probe stream"),
      FromSession("session's breath", available.breath,
                  "the session has no breathing stream; /effects/breathing/from_session "
                  "\"if_recorded\" would take the scenario's"),
      Volume(s, "ct", s.patient.ct),
      Volume(s, "labels", s.patient.labels),
      OfPatient("mesh", s.patient.mesh, "; acus-mesh --condense makes one"),
      OfPatient("corridor", s.patient.corridor, ": a CSV with the points entry and target"),
      {{"needle preset", s.needle, "/needle"}, ""},
      {{"probe preset", s.probe, "/probe"}, ""},
  };
  const auto add = [&inputs](std::string_view name, const fs::path& file, const char* where) {
    inputs.push_back({{name, file, where}, ""});
  };
  if (s.breathing) {
    add("motion", s.breathing->motion, "/effects/breathing/motion");
    add("breath signal", s.breathing->signal, "/effects/breathing/signal");
  }
  if (s.needle_force) add("force table", s.needle_force->table, "/effects/needle_force/table");
  if (s.shape) add("needle's elasticity", s.shape->elasticity, "/effects/needle/elasticity");
  if (s.probe_force) add("probe's force table", s.probe_force->table, "/effects/probe_force/table");
  if (s.tissue) {
    add("tissue's elasticity", s.tissue->elasticity, "/effects/tissue/elasticity");
    add("tissue's force table", s.tissue->table, "/effects/tissue/table");
  }
  if (s.ultrasound) add("acoustics", s.ultrasound->acoustics, "/effects/ultrasound");
  if (s.fluoroscopy) add("C-arm", s.fluoroscopy->c_arm, "/effects/fluoroscopy/c_arm");
  return inputs;
}

}  // namespace acus::simulation
