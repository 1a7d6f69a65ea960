#include "acus/scene/simulation/coupled/coupled_effect.h"
#include "acus/scene/simulation/coupled/declaration.h"
#include "acus/scene/simulation/probe_scene.h"

namespace acus::simulation::coupled {
namespace {

using scenario::Scenario;

bool IsFeltFromTissueByProbe(const Scenario& s) {
  return s.probe_force && s.probe_force->model == scenario::ProbeForceModelKind::kTissue;
}

Ports ProbeForceInputs(const Scenario& s) {
  if (!s.probe_force) return {};
  if (IsFeltFromTissueByProbe(s)) return {ports::kContact};
  Ports reads{ports::kProbePoses, ports::kProbeForceTable,
              s.probe_force->reads_labels ? effects::PortRef(ports::kLabels)
                                          : effects::PortRef(ports::kCt)};
  if (s.probe_force->NeedsProbePreset()) Add(reads, {ports::kProbePreset});
  AddMotion(s, reads);
  return reads;
}

Sleep SleepOf(const StepFrame& frame) noexcept {
  if (frame.out.probe.on_skin) return Sleep::kAwake;
  return frame.sample.probe_valid ? Sleep::kProbeOffSkin : Sleep::kProbeUnseen;
}

/// The force of the deformed tissue on the probe, no larger than its table's limit.
class ProbeFromTissueStage final : public CoupledStage {
 public:
  explicit ProbeFromTissueStage(const Scene& scene) : largest_n_(scene.tissue->LargestForceN()) {}

  Sleep Step(StepFrame& frame) const noexcept override {
    const tissue::TissueForce& tissue = frame.out.tissue;
    forces::ProbeForce& felt = frame.out.probe;
    felt = {.force_in_ct_n = tissue.probe_in_ct_n,
            .on_skin = tissue.num_probe_nodes > 0,
            .skin_mm = tissue.probe_depth_mm,
            .torque_in_ct_n_mm = tissue.probe_torque_in_ct_n_mm,
            .num_on_skin = tissue.num_probe_nodes};
    const double size_n = felt.force_in_ct_n.norm();
    if (size_n > largest_n_) {
      felt.force_in_ct_n *= largest_n_ / size_n;
      felt.torque_in_ct_n_mm *= largest_n_ / size_n;
    }
    return SleepOf(frame);
  }

 private:
  double largest_n_;
};

class ProbeForceStage final : public CoupledStage {
 public:
  explicit ProbeForceStage(const Scene& scene) : scene_(scene) {}

  void Begin(State& state) const override { state.probe = scene_.probe_force->NewState(); }

  Sleep Step(StepFrame& frame) const noexcept override {
    frame.out.probe = scene_.probe_force->Step(
        frame.state.probe, {.time_s = frame.time_s(),
                            .ct_from_probe = PressedProbe(frame.tools, scene_.probe_press_mm),
                            .valid = frame.sample.probe_valid});
    return SleepOf(frame);
  }

 private:
  const Scene& scene_;
};

class ProbeForceEffect final : public CoupledEffect {
 public:
  std::string_view key() const override { return "probe_force"; }

  std::vector<PlannedStage> Stages(const Scenario& s, bool /*breath_from_session*/) const override {
    return {StepStage("probe force", ProbeForceInputs(s), {ports::kProbeForce})};
  }

  Ports Goals(const Scenario& s) const override {
    if (!s.probe_force) return {};
    return {ports::kProbeForce};
  }

  Ports Helpers(const Scenario& s) const override {
    if (!s.probe_force || !s.probe_force->presses_images) return {};
    return {ports::kRestMap};
  }

  bool Offers(const Scenario& s, effects::PortRef port) const override {
    return port == ports::kRestMap && s.probe_force && s.probe_force->presses_images;
  }

  std::vector<effects::Knob> Knobs(const Scenario& s) const override {
    if (!s.probe_force) return {};
    std::vector<effects::Knob> knobs{{.name = "probe_force_model",
                                      .title = "law of the force on the probe",
                                      .key = "model",
                                      .acts_on = effects::ActsOn::kForce,
                                      .values = {"vidal", "multi_proxy"},
                                      .papers = {{"vidal", "Vidal-2008, section 3.3.1"},
                                                 {"multi_proxy", "Fortmeier-2016, palpation"}}}};
    if (s.probe_force->model == scenario::ProbeForceModelKind::kMultiProxy) {
      knobs.push_back({.name = "probe_proxies",
                       .title = "proxies on the face of the probe",
                       .key = "multi_proxy/proxies",
                       .acts_on = effects::ActsOn::kForce,
                       .values = {1, 4, 8, 16, 32, 64}});
    }
    return knobs;
  }

  void AddInputs(const Scenario& s, std::vector<DeclaredInput>& inputs) const override {
    if (!s.probe_force || IsFeltFromTissueByProbe(s)) return;
    inputs.push_back(
        File(ports::kProbeForceTable, s.probe_force->table, "/effects/probe_force/table"));
  }

  void Load(const Scenario& s, Scene& scene, RunContext& context) const override {
    if (!scene.plan.Writes(ports::kProbeForce)) return;
    LoadProbeForce(s, scene, context);
    if (!scene.probe_force_from_tissue) context.provenance.AddInput(s.probe_force->table);
  }

  std::unique_ptr<const CoupledStage> NewStage(effects::PortRef writes,
                                               const Scene& scene) const override {
    if (writes != ports::kProbeForce) return nullptr;
    if (scene.probe_force_from_tissue) return std::make_unique<ProbeFromTissueStage>(scene);
    return std::make_unique<ProbeForceStage>(scene);
  }
};

}  // namespace

const CoupledEffect& ProbeForce() {
  static const ProbeForceEffect effect;
  return effect;
}

}  // namespace acus::simulation::coupled
