#include "acus/scene/simulation/declared_stages.h"

#include <algorithm>
#include <iterator>
#include <span>

#include "acus/base/core/error.h"
#include "acus/scene/effects/ports.h"

namespace acus::simulation {
namespace {

namespace fs = std::filesystem;
namespace ports = effects::ports;
using effects::PortRef;
using scenario::Scenario;
using Ports = std::vector<PortRef>;

void Add(Ports& reads, const Ports& more) {
  reads.insert(reads.end(), more.begin(), more.end());
}

bool FromTissue(const Scenario& s) {
  return s.needle_force && s.needle_force->model == scenario::NeedleForceModelKind::kTissue;
}

/// True if an effect of the list moves tissue, whatever the tools do.
bool Moved(const Scenario& s) {
  return std::ranges::any_of(s.listed, &effects::CalledEffect::MovesTissue);
}

/// True if the images show tissue elsewhere than the CT does.
bool ShowsDeformation(const Scenario& s) {
  return (s.tissue && s.tissue->image) || (s.breathing && s.breathing->image) || Moved(s);
}

/// A recorded signal is only read where the session does not say how the patient breathes.
Ports BreathingInputs(const Scenario& s, bool from_session) {
  if (!s.breathing) return {};
  if (from_session || s.breathing->from_session == scenario::SessionBreath::kAlways) {
    return {ports::kMotion, ports::kSessionBreath};
  }
  if (s.breathing->signal.empty()) return {ports::kMotion};
  return {ports::kMotion, ports::kBreathSignal};
}

/// What moves the tissue under a tool.
void AddMotion(const Scenario& s, Ports& reads) {
  if (s.breathing) reads.emplace_back(ports::kBreath);
  if (Moved(s)) reads.emplace_back(ports::kTissueMotion);
}

/// A needle in a patient who breathes lies elsewhere in the CT.
Ports NeedlePoseInputs(const Scenario& s) {
  Ports reads{ports::kNeedlePoses};
  AddMotion(s, reads);
  return reads;
}

/// Without a label map tissues are told by the HU of the CT, as the force table says.
bool TissuesByHu(const Scenario& s) {
  return s.patient.labels.empty() && !s.patient.ct.empty();
}

Ports TissueLookupInputs(const Scenario& s) {
  return TissuesByHu(s) ? Ports{ports::kNeedle, ports::kCt, ports::kForceTable}
                        : Ports{ports::kNeedle, ports::kLabels};
}

/// What tissue under a tool is computed from, besides the tool.
Ports TissueStageInputs(const Scenario& s) {
  if (!s.tissue) return {};
  Ports reads{ports::kNeedle, ports::kNeedlePreset, ports::kTissueElasticity,
              ports::kTissueForceTable};
  switch (s.tissue->model) {
    case scenario::TissueModelKind::kDisplacementFunctions:
      return {};  // Nothing that steps: see DeformationInputs.
    case scenario::TissueModelKind::kSprings:
      Add(reads, {ports::kLabels});
      break;
    case scenario::TissueModelKind::kPlane2010:
      Add(reads, {ports::kLabels, ports::kCorridor});
      break;
    case scenario::TissueModelKind::kFem3d:
      Add(reads, {ports::kMesh});
      if (s.tissue->finite_strain) Add(reads, {ports::kCorridor});
      if (s.tissue->probe_contact) Add(reads, {ports::kProbePoses, ports::kProbePreset});
      break;
  }
  if (s.tissue->probe_contact) AddMotion(s, reads);
  return reads;
}

/// What the force on the needle is computed from. The CT itself tells Vidal's model what it meets;
/// tissues are looked up for the log.
Ports ForceInputs(const Scenario& s) {
  if (!s.needle_force) return {};
  if (FromTissue(s)) return {ports::kContact};
  Ports reads{ports::kNeedle, ports::kTissue, ports::kNeedlePreset, ports::kForceTable};
  if (s.needle_force->model == scenario::NeedleForceModelKind::kVidal) Add(reads, {ports::kCt});
  if (s.needle_force->model == scenario::NeedleForceModelKind::kMeasured) {
    Add(reads, {ports::kMeasuredForce});
  }
  if (s.needle_force->skin_nick_radius_mm > 0.0) Add(reads, {ports::kCorridor});
  return reads;
}

/// What the needle's shape comes from: the path that the force model knows, and the tissue on it.
Ports ShapeInputs(const Scenario& s) {
  if (!s.shape) return {};
  Ports reads{ports::kNeedle, ports::kForce, ports::kNeedlePreset,
              FromTissue(s) ? ports::kTissueForceTable : ports::kForceTable};
  if (s.shape->model != scenario::NeedleModelKind::kBendable) return reads;
  Add(reads, {FromTissue(s) ? PortRef(ports::kContact) : PortRef(ports::kTissue),
              ports::kNeedleElasticity});
  // Which tissues there are; a mesh does not say, and all that can be deformed are taken.
  if (FromTissue(s) ? s.tissue->model != scenario::TissueModelKind::kFem3d : !TissuesByHu(s)) {
    Add(reads, {ports::kLabels});
  }
  if (s.breathing) Add(reads, {ports::kBreath});
  return reads;
}

/// What the force on the probe is computed from, at every sample.
Ports ProbeForceInputs(const Scenario& s) {
  if (!s.probe_force) return {};
  if (s.probe_force->model == scenario::ProbeForceModelKind::kTissue) return {ports::kContact};
  Ports reads{ports::kProbePoses, ports::kProbeForceTable,
              s.probe_force->reads_labels ? PortRef(ports::kLabels) : PortRef(ports::kCt)};
  if (s.probe_force->NeedsProbePreset()) Add(reads, {ports::kProbePreset});
  AddMotion(s, reads);
  return reads;
}

/// What the deformation in the images comes from.
Ports DeformationInputs(const Scenario& s) {
  Ports reads;
  if (s.tissue && s.tissue->image) {
    reads = s.tissue->TouchesNeedle()
                ? Ports{ports::kContact}
                : Ports{ports::kForce, ports::kLabels, ports::kTissueElasticity};
    if (s.tissue->model == scenario::TissueModelKind::kFem3d) reads.push_back(ports::kMesh);
  }
  if (s.breathing && s.breathing->image) Add(reads, {ports::kBreath});
  if (Moved(s)) Add(reads, {ports::kTissueMotion});
  return reads;
}

void AddNeedleInPicture(const Scenario& s, Ports& reads) {
  Add(reads, {ports::kNeedle, ports::kNeedlePreset});
  if (s.shape) Add(reads, {ports::kShape});
}

/// What an image reads besides the patient: the probe, the needle and the deformation if they show.
Ports ImageInputs(const Scenario& s, bool needle, Ports patient) {
  Ports reads = std::move(patient);
  Add(reads, {ports::kProbe, ports::kProbePreset});
  if (needle) AddNeedleInPicture(s, reads);
  if (ShowsDeformation(s)) Add(reads, {ports::kRestMap});
  return reads;
}

Ports CtSliceInputs(const Scenario& s) {
  if (!s.ct_slice) return {};
  return ImageInputs(s, s.ct_slice->needle, {ports::kCt});
}

Ports UltrasoundInputs(const Scenario& s) {
  if (!s.ultrasound) return {};
  Ports patient;
  if (s.ultrasound->ReadsCt()) patient.push_back(ports::kCt);
  if (s.ultrasound->ReadsLabels()) patient.push_back(ports::kLabels);
  patient.push_back(ports::kAcoustics);
  return ImageInputs(s, s.ultrasound->needle, std::move(patient));
}

bool ReadsWhatIsWritten(const effects::StageDeclaration& stage,
                        std::span<const PlannedStage> writers) {
  return std::ranges::any_of(writers, [&stage](const PlannedStage& writer) {
    return std::ranges::find_first_of(writer.writes, stage.reads) != writer.writes.end();
  });
}

/// True if the scene has what a stage reads only where it is there.
bool IsThere(const Scenario& s, PortRef port) {
  return (port == ports::kRestMap && ShowsDeformation(s)) || (port == ports::kShape && s.shape) ||
         (port == ports::kBreath && s.breathing && s.breathing->image) ||
         (port == ports::kBMode && s.ultrasound) || (port == ports::kCtImage && s.ct_slice);
}

PlannedStage Planned(const Scenario& s, StageId id, std::string_view rate,
                     const effects::StageDeclaration& stage) {
  PlannedStage planned{id, stage.name, rate, stage.reads, stage.writes, false, "", {}};
  std::ranges::copy_if(stage.optional_reads, std::back_inserter(planned.reads),
                       [&s](PortRef port) { return IsThere(s, port); });
  return planned;
}

/// Of the list of effects: at every sample those that read nothing of a tool's stages come right
/// after breathing, so that tools see what they write; others after the tools. At every image they
/// are last.
void AddListed(const Scenario& s, std::vector<PlannedStage>& stages) {
  ACUS_REQUIRE(s.listed.size() <= kMaxListed, s.file.string(), ": calls for ", s.listed.size(),
               " effects of the list; at most ", kMaxListed, " are allowed");
  const auto is_image = [](const PlannedStage& stage) { return stage.rate == "image"; };
  for (std::size_t n = 0; n < s.listed.size(); ++n) {
    if (const auto step = s.listed[n].step()) {
      const auto end_of_steps = std::ranges::find_if(stages, is_image);
      const auto first_of_tools =
          std::ranges::find(stages, StageId::kNeedlePose, &PlannedStage::id);
      const bool after = ReadsWhatIsWritten(*step, {first_of_tools, end_of_steps});
      stages.insert(after ? end_of_steps : first_of_tools,
                    Planned(s, StepStageOf(n), "step", *step));
    }
    if (const auto image = s.listed[n].image()) {
      stages.push_back(Planned(s, ImageStageOf(n), "image", *image));
    }
  }
}

}  // namespace

std::vector<PlannedStage> DeclaredStages(const Scenario& s, bool breath_from_session) {
  const auto step = [](StageId id, std::string_view name, Ports reads, Ports writes) {
    return PlannedStage{id, name, "step", std::move(reads), std::move(writes), false, "", {}};
  };
  const auto image = [](StageId id, std::string_view name, Ports reads, Ports writes) {
    return PlannedStage{id, name, "image", std::move(reads), std::move(writes), false, "", {}};
  };
  std::vector<PlannedStage> stages = {
      step(StageId::kBreathing, "breathing", BreathingInputs(s, breath_from_session),
           {ports::kBreath}),
      step(StageId::kNeedlePose, "needle pose", NeedlePoseInputs(s), {ports::kNeedle}),
      step(StageId::kTissueLookup, "tissue lookup", TissueLookupInputs(s), {ports::kTissue}),
      step(StageId::kTissueContact, "tissue contact", TissueStageInputs(s), {ports::kContact}),
      step(StageId::kNeedleForce, "needle force", ForceInputs(s), {ports::kForce}),
      step(StageId::kNeedleShape, "needle shape", ShapeInputs(s), {ports::kShape}),
      step(StageId::kProbeForce, "probe force", ProbeForceInputs(s), {ports::kProbeForce}),
      image(StageId::kProbePose, "probe pose", {ports::kProbePoses}, {ports::kProbe}),
      image(StageId::kDeformation, "deformation", DeformationInputs(s), {ports::kRestMap}),
      image(StageId::kCtSlice, "CT slice", CtSliceInputs(s), {ports::kCtImage}),
      image(StageId::kUltrasound, "B-mode", UltrasoundInputs(s), {ports::kBMode}),
  };
  AddListed(s, stages);
  return stages;
}

std::vector<Goal> GoalsOf(const Scenario& s) {
  std::vector<Goal> goals;
  if (s.needle_force) goals.push_back({StageId::kNeedleForce, "needle_force"});
  if (s.shape) goals.push_back({StageId::kNeedleShape, "needle"});
  if (s.probe_force) goals.push_back({StageId::kProbeForce, "probe_force"});
  if (s.tissue && s.tissue->TouchesNeedle()) goals.push_back({StageId::kTissueContact, "tissue"});
  if (s.ct_slice) goals.push_back({StageId::kCtSlice, "ct_slice"});
  if (s.ultrasound) goals.push_back({StageId::kUltrasound, "ultrasound"});
  for (std::size_t n = 0; n < s.listed.size(); ++n) {
    const std::string_view key = s.listed[n].effect->key();
    const auto step = s.listed[n].step();
    if (step && step->is_goal) goals.push_back({StepStageOf(n), key});
    const auto image = s.listed[n].image();
    if (image && image->is_goal) goals.push_back({ImageStageOf(n), key});
  }
  return goals;
}

std::vector<Goal> HelpersOf(const Scenario& s) {
  std::vector<Goal> helpers;
  if (s.breathing) helpers.push_back({StageId::kBreathing, "breathing"});
  if (s.tissue && s.tissue->image) helpers.push_back({StageId::kDeformation, "tissue"});
  if (s.breathing && s.breathing->image) helpers.push_back({StageId::kDeformation, "breathing"});
  for (std::size_t n = 0; n < s.listed.size(); ++n) {
    const std::string_view key = s.listed[n].effect->key();
    const auto step = s.listed[n].step();
    if (step && !step->is_goal) helpers.push_back({StepStageOf(n), key});
    if (s.listed[n].MovesTissue()) helpers.push_back({StageId::kDeformation, key});
  }
  return helpers;
}

namespace {

DeclaredInput FromSession(PortRef port, bool there, const char* remedy) {
  return {{port, {}, ""}, there ? "" : remedy};
}

/// A file of the patient, which the scenario may leave out if nobody reads it.
DeclaredInput OfPatient(PortRef port, const fs::path& file, const char* remedy) {
  const std::string where = Message("/patient/", port.name());
  return {{port, file, where}, file.empty() ? Message(where, " is not given", remedy) : ""};
}

/// CT and labels, or the list of surfaces from which both are made.
DeclaredInput Volume(const Scenario& s, PortRef port, const fs::path& file) {
  if (s.patient.surfaces.empty()) return OfPatient(port, file, "");
  return {{port, s.patient.surfaces, "/patient/surfaces"}, ""};
}

}  // namespace

std::vector<DeclaredInput> DeclaredInputs(const Scenario& s, const AvailableInputs& available) {
  std::vector<DeclaredInput> inputs = {
      FromSession(ports::kNeedlePoses, available.needle_poses, "the session has no needle stream"),
      FromSession(ports::kProbePoses, available.probe_poses, "the session has no probe stream"),
      FromSession(ports::kSessionBreath, available.breath,
                  "the session has no breathing stream; /effects/breathing/from_session "
                  "\"if_recorded\" would take the scenario's"),
      Volume(s, ports::kCt, s.patient.ct),
      Volume(s, ports::kLabels, s.patient.labels),
      OfPatient(ports::kMesh, s.patient.mesh, "; acus-mesh --condense makes one"),
      OfPatient(ports::kCorridor, s.patient.corridor, ": a CSV with the points entry and target"),
      {{ports::kNeedlePreset, s.needle, "/needle"}, ""},
      {{ports::kProbePreset, s.probe, "/probe"}, ""},
  };
  const auto add = [&inputs](PortRef port, const fs::path& file, const std::string& where) {
    inputs.push_back({{port, file, where}, ""});
  };
  if (s.breathing) {
    add(ports::kMotion, s.breathing->motion, "/effects/breathing/motion");
    add(ports::kBreathSignal, s.breathing->signal, "/effects/breathing/signal");
  }
  if (s.needle_force) add(ports::kForceTable, s.needle_force->table, "/effects/needle_force/table");
  if (s.needle_force && !s.needle_force->measured.empty()) {
    add(ports::kMeasuredForce, s.needle_force->measured, "/effects/needle_force/measured");
  }
  if (s.shape) add(ports::kNeedleElasticity, s.shape->elasticity, "/effects/needle/elasticity");
  if (s.probe_force && s.probe_force->model != scenario::ProbeForceModelKind::kTissue)
    add(ports::kProbeForceTable, s.probe_force->table, "/effects/probe_force/table");
  if (s.tissue) {
    add(ports::kTissueElasticity, s.tissue->elasticity, "/effects/tissue/elasticity");
    add(ports::kTissueForceTable, s.tissue->table, "/effects/tissue/table");
  }
  if (s.ultrasound) add(ports::kAcoustics, s.ultrasound->acoustics, "/effects/ultrasound");
  for (const effects::CalledEffect& other : s.listed) {
    for (const effects::PathSetting& path : other.effect->Paths()) {
      if (!other.settings.contains(path.key)) continue;
      add(path.port, other.settings[path.key].get<std::string>(),
          Message("/effects/", other.effect->key(), "/", path.key));
    }
  }
  return inputs;
}

}  // namespace acus::simulation
