#include "acus/scene/simulation/coupled/declaration.h"

#include <algorithm>
#include <utility>

namespace acus::simulation::coupled {

using scenario::Scenario;

void Add(Ports& reads, const Ports& more) {
  reads.insert(reads.end(), more.begin(), more.end());
}

PlannedStage StepStage(std::string_view name, Ports reads, Ports writes) {
  return {name, "step", std::move(reads), std::move(writes)};
}

PlannedStage ImageStage(std::string_view name, Ports reads, Ports writes) {
  return {name, "image", std::move(reads), std::move(writes)};
}

DeclaredInput File(effects::PortRef port, const std::filesystem::path& file,
                   const std::string& where) {
  return {{port, file, where}, ""};
}

bool IsFeltFromTissue(const Scenario& s) {
  return s.needle_force && s.needle_force->model == scenario::NeedleForceModelKind::kTissue;
}

bool AreTissuesByHu(const Scenario& s) {
  return s.patient.labels.empty() && !s.patient.ct.empty() && s.needle_force &&
         !IsFeltFromTissue(s);
}

bool AreSpringsByHu(const Scenario& s) {
  return s.patient.labels.empty() && !s.patient.ct.empty() && s.tissue &&
         s.tissue->model == scenario::TissueModelKind::kSprings;
}

bool ShowsDeformation(const Scenario& s) {
  return (s.tissue && s.tissue->image) || (s.breathing && s.breathing->image) || IsTissueMoved(s) ||
         IsWrittenByListed(s, ports::kSwelling) || (s.probe_force && s.probe_force->presses_images);
}

bool IsWrittenByListed(const Scenario& s, effects::PortRef port) {
  return std::ranges::any_of(s.listed,
                             [port](const auto& called) { return called.StepWrites(port); });
}

bool IsTissueMoved(const Scenario& s) {
  return IsWrittenByListed(s, ports::kTissueMotion);
}

bool HasProbeImage(const Scenario& s) {
  return s.ultrasound || s.ct_slice;
}

void AddMotion(const Scenario& s, Ports& reads) {
  if (s.breathing) reads.emplace_back(ports::kBreath);
  if (IsTissueMoved(s)) reads.emplace_back(ports::kTissueMotion);
}

Ports ImageInputs(const Scenario& s, bool needle, Ports patient) {
  Ports reads = std::move(patient);
  Add(reads, {ports::kProbe, ports::kProbePreset});
  if (needle) {
    Add(reads, {ports::kNeedle, ports::kNeedlePreset});
    if (s.shape) Add(reads, {ports::kShape});
  }
  if (ShowsDeformation(s)) Add(reads, {ports::kRestMap});
  return reads;
}

}  // namespace acus::simulation::coupled
