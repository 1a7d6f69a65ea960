#include "acus/scene/simulation/declared_stages.h"

#include <algorithm>
#include <iterator>
#include <span>

#include "acus/base/core/error.h"
#include "acus/scene/effects/ports.h"
#include "acus/scene/simulation/coupled/coupled_effect.h"

namespace acus::simulation {
namespace {

namespace fs = std::filesystem;
namespace ports = effects::ports;
using effects::PortRef;
using scenario::Scenario;

bool ReadsWhatIsWritten(const effects::StageDeclaration& stage,
                        std::span<const PlannedStage> writers) {
  return std::ranges::any_of(writers, [&stage](const PlannedStage& writer) {
    return std::ranges::find_first_of(writer.writes, stage.reads) != writer.writes.end();
  });
}

/// True if the scene has what a stage reads only where it is there.
bool IsThere(const Scenario& s, PortRef port) {
  return std::ranges::any_of(CoupledEffects(), [&s, port](const CoupledEffect* effect) {
    return effect->Offers(s, port);
  });
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
  std::vector<PlannedStage> stages;
  for (const CoupledEffect* effect : CoupledEffects()) {
    std::ranges::move(effect->Stages(s, breath_from_session), std::back_inserter(stages));
  }
  std::ranges::sort(stages, {}, &PlannedStage::id);
  AddListed(s, stages);
  return stages;
}

std::vector<Goal> GoalsOf(const Scenario& s) {
  std::vector<Goal> goals;
  for (const CoupledEffect* effect : CoupledEffects()) {
    std::ranges::copy(effect->Goals(s), std::back_inserter(goals));
  }
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
  for (const CoupledEffect* effect : CoupledEffects()) {
    std::ranges::copy(effect->Helpers(s), std::back_inserter(helpers));
  }
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
  for (const CoupledEffect* effect : CoupledEffects()) effect->AddInputs(s, inputs);
  for (const effects::CalledEffect& other : s.listed) {
    for (const effects::PathSetting& path : other.effect->Paths()) {
      if (!other.settings.contains(path.key)) continue;
      inputs.push_back({{path.port, other.settings[path.key].get<std::string>(),
                         Message("/effects/", other.effect->key(), "/", path.key)},
                        ""});
    }
  }
  return inputs;
}

}  // namespace acus::simulation
