#include "acus/physics/forces/models/measured_forces.h"
#include "acus/scene/simulation/coupled/coupled_effect.h"
#include "acus/scene/simulation/coupled/declaration.h"
#include "acus/scene/simulation/needle_line.h"
#include "acus/scene/simulation/patient_tables.h"

namespace acus::simulation::coupled {
namespace {

using scenario::NeedleForceModelKind;
using scenario::Scenario;

/// The inputs of the force on the needle. Vidal's model reads the CT itself; for it, tissues are
/// looked up for the log only.
Ports ForceInputs(const Scenario& s) {
  if (!s.needle_force) return {};
  if (IsFeltFromTissue(s)) return {ports::kContact};
  Ports reads{ports::kNeedle, ports::kTissue, ports::kNeedlePreset, ports::kForceTable};
  if (s.needle_force->model == NeedleForceModelKind::kVidal) Add(reads, {ports::kCt});
  if (s.needle_force->model == NeedleForceModelKind::kMeasured) {
    Add(reads, {ports::kMeasuredForce});
  }
  if (s.needle_force->skin_nick_radius_mm > 0.0) Add(reads, {ports::kCorridor});
  return reads;
}

forces::GuidanceKind GuidanceOf(scenario::GuidanceKind kind) {
  switch (kind) {
    case scenario::GuidanceKind::kOwn:
      return forces::GuidanceKind::kOwn;
    case scenario::GuidanceKind::kNone:
      return forces::GuidanceKind::kNone;
    case scenario::GuidanceKind::kVidal:
      return forces::GuidanceKind::kVidal;
    case scenario::GuidanceKind::kVirtualFixture:
      return forces::GuidanceKind::kVirtualFixture;
  }
  ACUS_ASSERT(false);
}

forces::ForceTable ReadTable(const Scenario& s, RunContext& context) {
  forces::ForceTable table = ForcesOf(s.patient, s.needle_force->table, context);
  table.alamilla.direct_method = s.needle_force->direct_method;
  if (const double nick_mm = s.needle_force->skin_nick_radius_mm; nick_mm > 0.0) {
    table.nick = {ReadNeedleLine(s.patient.corridor).entry_in_ct_mm, nick_mm};
    context.provenance.AddInput(s.patient.corridor);
  }
  return table;
}

/// The seed by which a law of recordings is drawn; 0: the recording that is named.
std::uint64_t SeedOfRecordings(const Scenario& s) {
  const scenario::NeedleForceEffect& effect = *s.needle_force;
  const bool is_patients = effect.seed == 0 && effect.recording == "mean";
  return is_patients ? s.patient.stiffness_seed : effect.seed;
}

forces::ForceModel ModelOf(const Scenario& s, const forces::ForceTable& table, const Scene& scene,
                           RunContext& context) {
  const scenario::NeedleForceEffect& effect = *s.needle_force;
  const forces::GuidanceKind guidance = GuidanceOf(effect.guidance);
  switch (effect.model) {
    case NeedleForceModelKind::kVidal:
      return forces::ForceModel(forces::VidalModel(table, *scene.needle, *scene.hu, guidance));
    case NeedleForceModelKind::kAlamilla:
      return forces::ForceModel(forces::AlamillaModel(table, *scene.needle, guidance));
    case NeedleForceModelKind::kMeasured: {
      const auto measured = forces::ReadMeasuredForces(effect.measured);
      context.provenance.AddInput(effect.measured);
      const std::uint64_t seed = SeedOfRecordings(s);
      return forces::ForceModel(forces::MeasuredModel(
          table, *scene.needle, seed > 0 ? measured.Drawn(seed) : measured.Law(effect.recording),
          measured.needle_diameter_mm, guidance));
    }
    case NeedleForceModelKind::kLayered:
    case NeedleForceModelKind::kTissue:  // Not loaded: see Load.
      break;
  }
  return forces::ForceModel(forces::NeedleForceModel(table, *scene.needle, guidance));
}

/// The force of the deformed tissue on the needle.
class NeedleFromTissueStage final : public CoupledStage {
 public:
  Sleep Step(StepFrame& frame) const noexcept override {
    frame.out.force = frame.out.tissue.needle;
    frame.out.tissue_at_tip = frame.out.tissue.tissue_at_tip;
    return frame.out.tissue.touched ? Sleep::kAwake : Sleep::kUntouched;
  }
};

class ForceStage final : public CoupledStage {
 public:
  explicit ForceStage(const Scene& scene) : scene_(scene) {}

  void Begin(State& state) const override { state.force = scene_.forces->NewState(); }

  Sleep Step(StepFrame& frame) const noexcept override {
    State& state = frame.state;
    // Idle while the needle is in free space; the law itself then returns at once.
    const bool is_outside = frame.out.tissue_at_tip == 0 && !forces::TrackOf(state.force).in_body;
    forces::SweptTissue swept{.lookup = frame.lookup};
    if (scene_.shape) swept.tip_offset_mm = state.shape.tip_offset_mm;
    frame.out.force = scene_.forces->StepAlong(state.force,
                                               {.time_s = frame.time_s(),
                                                .tip_in_ct_mm = frame.tip_in_ct_mm(),
                                                .axis_in_ct = frame.axis_in_ct(),
                                                .tissue_at_tip = frame.out.tissue_at_tip,
                                                .valid = frame.sample.needle_valid},
                                               swept, state.passed);
    return is_outside ? frame.outside() : Sleep::kAwake;
  }

 private:
  const Scene& scene_;
};

class NeedleForceEffect final : public CoupledEffect {
 public:
  std::string_view key() const override { return "needle_force"; }

  std::vector<PlannedStage> Stages(const Scenario& s, bool /*breath_from_session*/) const override {
    return {StepStage("needle force", ForceInputs(s), {ports::kForce})};
  }

  Ports Goals(const Scenario& s) const override {
    if (!s.needle_force) return {};
    return {ports::kForce};
  }

  std::vector<effects::Knob> Knobs(const Scenario& s) const override {
    if (!s.needle_force) return {};
    return {{.name = "force_model",
             .title = "law of the force on the needle",
             .key = "model",
             .acts_on = effects::ActsOn::kForce,
             .values = {"vidal", "layered", "alamilla", "tissue"},
             .papers = {{"vidal", "Vidal-2008"}, {"alamilla", "Alamilla-2021"}}}};
  }

  bool Offers(const Scenario& s, effects::PortRef port) const override {
    return port == ports::kForce && s.needle_force;
  }

  void AddInputs(const Scenario& s, std::vector<DeclaredInput>& inputs) const override {
    if (!s.needle_force) return;
    inputs.push_back(
        File(ports::kForceTable, s.needle_force->table, "/effects/needle_force/table"));
    if (s.needle_force->measured.empty()) return;
    inputs.push_back(
        File(ports::kMeasuredForce, s.needle_force->measured, "/effects/needle_force/measured"));
  }

  void Load(const Scenario& s, Scene& scene, RunContext& context) const override {
    scene.force_from_tissue = IsFeltFromTissue(s);
    if (!scene.plan.Writes(ports::kForce) || scene.force_from_tissue) return;
    const forces::ForceTable table = ReadTable(s, context);
    const bool are_tissues_by_hu = scene.plan.Reads(ports::kTissue, ports::kCt);
    const bool is_force_by_hu = s.needle_force->model == NeedleForceModelKind::kVidal;
    if (is_force_by_hu || are_tissues_by_hu) NeedHu(scene);
    if (are_tissues_by_hu) {
      context.Warn(
          "there is no label map: tissues are identified by the CT's HU, as the force table says");
      scene.hu_tissues = table.hu_tissues;
    }
    scene.forces.emplace(ModelOf(s, table, scene, context));
    context.provenance.AddInput(s.needle_force->table);
  }

  std::unique_ptr<const CoupledStage> NewStage(effects::PortRef writes,
                                               const Scene& scene) const override {
    if (writes != ports::kForce) return nullptr;
    if (scene.force_from_tissue) return std::make_unique<NeedleFromTissueStage>();
    return std::make_unique<ForceStage>(scene);
  }
};

}  // namespace

const CoupledEffect& NeedleForce() {
  static const NeedleForceEffect effect;
  return effect;
}

}  // namespace acus::simulation::coupled
