#include "acus/scene/simulation/coupled/coupled_effect.h"
#include "acus/scene/simulation/coupled/declaration.h"

namespace acus::simulation::coupled {
namespace {

using scenario::Scenario;

/// A recorded signal is only read where the session holds no breath.
Ports BreathInputs(const Scenario& s, bool from_session) {
  if (!s.breathing) return {};
  if (from_session || s.breathing->from_session == scenario::SessionBreath::kAlways) {
    return {ports::kMotion, ports::kSessionBreath};
  }
  if (s.breathing->signal.empty()) return {ports::kMotion};
  return {ports::kMotion, ports::kBreathSignal};
}

/// Before the stages, ToolMotion::Lay maps every tool into the patient at rest.
class BreathStage final : public CoupledStage {
 public:
  Sleep Step(StepFrame& frame) const noexcept override {
    return frame.tools.tissue_moves ? Sleep::kAwake : Sleep::kAtRest;
  }
};

class BreathingEffect final : public CoupledEffect {
 public:
  std::string_view key() const override { return "breathing"; }

  std::vector<PlannedStage> Stages(const Scenario& s, bool breath_from_session) const override {
    return {StepStage("breathing", BreathInputs(s, breath_from_session), {ports::kBreath})};
  }

  Ports Helpers(const Scenario& s) const override {
    if (!s.breathing) return {};
    Ports helpers{ports::kBreath};
    if (s.breathing->image) helpers.emplace_back(ports::kRestMap);
    return helpers;
  }

  bool Offers(const Scenario& s, effects::PortRef port) const override {
    return port == ports::kBreath && s.breathing && s.breathing->image;
  }

  std::vector<effects::Knob> Knobs(const Scenario& s) const override {
    if (!s.breathing) return {};
    std::vector<effects::Knob> knobs{
        {.name = "motion",
         .title = "motion of the breathing patient: model and resolution",
         .key = "motion",
         .is_folder = true,
         .scenario_value = s.breathing->motion.string()}};
    if (!s.breathing->image || !HasProbeImage(s)) return knobs;
    knobs.push_back({.name = "breathing_warp_spacing_mm",
                     .title = "knots at which images evaluate the patient's breath",
                     .unit = "mm",
                     .key = "warp_spacing_mm",
                     .acts_on = effects::ActsOn::kImage,
                     .values = {20, 10, 5, 2, 1}});
    knobs.push_back(
        {.name = "breathing_inverse_iterations",
         .title = "iterations to find where a knot was at rest",
         .key = "inverse_iterations",
         .acts_on = effects::ActsOn::kImage,
         .values = {1, 2, 3, 5, 10, 50},
         .papers = {{5, "Fortmeier-2016, figure 11"}, {50, "Fortmeier-2016, figure 11"}}});
    return knobs;
  }

  void AddInputs(const Scenario& s, std::vector<DeclaredInput>& inputs) const override {
    if (!s.breathing) return;
    inputs.push_back(File(ports::kMotion, s.breathing->motion, "/effects/breathing/motion"));
    inputs.push_back(File(ports::kBreathSignal, s.breathing->signal, "/effects/breathing/signal"));
  }

  void Load(const Scenario& s, Scene& scene, RunContext& context) const override {
    if (!scene.plan.Writes(ports::kBreath)) return;
    context.Checkpoint("reading the motion", 0.0);
    scene.breathing.emplace(LoadBreathing(s, scene.plan.breath_from_session(), context));
  }

  std::unique_ptr<const CoupledStage> NewStage(effects::PortRef writes,
                                               const Scene& /*scene*/) const override {
    if (writes != ports::kBreath) return nullptr;
    return std::make_unique<BreathStage>();
  }
};

}  // namespace

const CoupledEffect& Breathing() {
  static const BreathingEffect effect;
  return effect;
}

}  // namespace acus::simulation::coupled
