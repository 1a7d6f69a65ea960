#include "acus/scene/simulation/declared_stages.h"

#include <algorithm>
#include <functional>
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

/// True if an effect of the scenario offers a port that a stage reads optionally.
bool IsThere(const Scenario& s, PortRef port) {
  return std::ranges::any_of(CoupledEffects(), [&s, port](const CoupledEffect* effect) {
    return effect->Offers(s, port);
  });
}

PlannedStage Planned(const Scenario& s, std::string_view owner, std::string_view rate,
                     const effects::StageDeclaration& stage) {
  PlannedStage planned{stage.name, rate, stage.reads, stage.writes, owner};
  std::ranges::copy_if(stage.optional_reads, std::back_inserter(planned.reads),
                       [&s](PortRef port) { return IsThere(s, port); });
  return planned;
}

/// Stages of coupled effects: those at every sample, then those at every image, each in the order
/// of the effects.
std::vector<PlannedStage> CoupledStages(const Scenario& s, bool breath_from_session) {
  std::vector<PlannedStage> stages;
  for (const CoupledEffect* effect : CoupledEffects()) {
    for (PlannedStage& stage : effect->Stages(s, breath_from_session)) {
      stage.owner = effect->key();
      stages.push_back(std::move(stage));
    }
  }
  std::ranges::stable_partition(stages, std::not_fn(&PlannedStage::is_image));
  return stages;
}

/// Adds the stages of the list of effects. At every sample, those that read nothing of a tool's
/// stages come right after breathing, so that tools see their output; the others come after the
/// tools. At every image they are last.
void AddListed(const Scenario& s, std::vector<PlannedStage>& stages) {
  for (const effects::CalledEffect& called : s.listed) {
    if (const auto step = called.step()) {
      const auto end_of_steps = std::ranges::find_if(stages, &PlannedStage::is_image);
      const auto first_of_tools = std::ranges::find_if(
          stages, [](const PlannedStage& stage) { return stage.Writes(ports::kNeedle); });
      const bool after = ReadsWhatIsWritten(*step, {first_of_tools, end_of_steps});
      stages.insert(after ? end_of_steps : first_of_tools,
                    Planned(s, called.effect->key(), "step", *step));
    }
    if (const auto image = called.image()) {
      stages.push_back(Planned(s, called.effect->key(), "image", *image));
    }
  }
}

template <typename Predicate>
std::size_t FirstWhere(const std::vector<PlannedStage>& stages, Predicate is_wanted) {
  const auto found = std::ranges::find_if(stages, is_wanted);
  ACUS_ASSERT(found != stages.end());
  return found->number;
}

/// Number of the first stage that writes a port.
std::size_t NumberOf(const std::vector<PlannedStage>& stages, PortRef port) {
  return FirstWhere(stages, [port](const PlannedStage& stage) { return stage.Writes(port); });
}

/// Number of an effect's stage at every sample or at every image.
std::size_t NumberOf(const std::vector<PlannedStage>& stages, std::string_view owner,
                     bool is_image) {
  return FirstWhere(stages, [owner, is_image](const PlannedStage& stage) {
    return stage.owner == owner && stage.is_image() == is_image;
  });
}

}  // namespace

DeclaredStages::DeclaredStages(const Scenario& s, bool breath_from_session)
    : stages(CoupledStages(s, breath_from_session)) {
  AddListed(s, stages);
  for (std::size_t n = 0; n < stages.size(); ++n) stages[n].number = n;
  for (const CoupledEffect* effect : CoupledEffects()) {
    for (const PortRef port : effect->Goals(s)) {
      goals.push_back({NumberOf(stages, port), effect->key()});
    }
    for (const PortRef port : effect->Helpers(s)) {
      helpers.push_back({NumberOf(stages, port), effect->key()});
    }
  }
  for (const effects::CalledEffect& called : s.listed) {
    const std::string_view key = called.effect->key();
    if (const auto step = called.step()) {
      (step->is_goal ? goals : helpers).push_back({NumberOf(stages, key, false), key});
    }
    const auto image = called.image();
    if (image && image->is_goal) goals.push_back({NumberOf(stages, key, true), key});
    if (called.StepWrites(ports::kTissueMotion) || called.StepWrites(ports::kSwelling)) {
      helpers.push_back({NumberOf(stages, ports::kRestMap), key});
    }
  }
}

namespace {

DeclaredInput FromSession(PortRef port, bool there, const char* remedy) {
  return {{port, {}, ""}, there ? "" : remedy};
}

/// A file of the patient; the scenario may omit it if no stage reads it.
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
      FromSession(ports::kPlungerForce, true, ""),
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
