// An effect that is coupled with others: tissue, needle, forces, breath and the images of the probe
// read each other's results by type. Plan, loader and step use the list of these effects and name
// none of them. An independent effect is an effects::Effect.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "acus/scene/effects/knob.h"
#include "acus/scene/simulation/declared_stages.h"
#include "acus/scene/simulation/scene.h"
#include "acus/scene/simulation/stage_timing.h"
#include "acus/scene/simulation/step_state.h"
#include "acus/scene/simulation/tools_at_rest.h"

namespace acus::simulation {

/// The state of a step that its stages share, one after the other.
struct StepFrame {
  const Sample& sample;
  const ToolsAtRest& tools;
  State& state;
  StepOutput& out;
  const forces::TissueLookup* lookup = nullptr;  ///< Set by the tissue lookup.

  double time_s() const noexcept { return 1e-9 * static_cast<double>(sample.time_ns); }
  const Eigen::Isometry3d& ct_from_needle() const noexcept { return tools.needle.ct_from_tool; }
  Eigen::Vector3d tip_in_ct_mm() const noexcept { return ct_from_needle().translation(); }
  Eigen::Vector3d axis_in_ct() const noexcept { return ct_from_needle().linear().col(2); }
  Sleep unseen() const noexcept { return state.needle_seen ? Sleep::kAwake : Sleep::kNeedleUnseen; }
  /// The reason for sleep of a stage whose needle is in no tissue.
  Sleep outside() const noexcept {
    return state.needle_seen ? Sleep::kNeedleOutside : Sleep::kNeedleUnseen;
  }
};

/// The computation of a stage at every sample. Const: all that changes is in the State.
class CoupledStage {
 public:
  virtual ~CoupledStage() = default;
  virtual void Begin(State& /*state*/) const {}
  /// Real time: must not allocate, lock, log or throw. The same inputs give the same bits.
  /// @return  kAwake, or why there was nothing to do.
  virtual Sleep Step(StepFrame& frame) const noexcept = 0;
};

/// A kind of effect. One object for each, of static storage.
class CoupledEffect {
 public:
  virtual ~CoupledEffect() = default;

  /// Key among the scenario's effects: "needle_force". Empty: shared by all effects.
  virtual std::string_view key() const = 0;
  /// All its stages, whether or not the scenario names them, in the order in which they run.
  virtual std::vector<PlannedStage> Stages(const scenario::Scenario& scenario,
                                           bool breath_from_session) const = 0;
  /// The outputs for whose sake the scenario names the effect.
  virtual std::vector<effects::PortRef> Goals(const scenario::Scenario& /*scenario*/) const {
    return {};
  }
  /// The outputs through which it acts, where another stage reads them.
  virtual std::vector<effects::PortRef> Helpers(const scenario::Scenario& /*scenario*/) const {
    return {};
  }
  /// True if the scenario has the port, for stages that read it optionally.
  virtual bool Offers(const scenario::Scenario& /*scenario*/, effects::PortRef /*port*/) const {
    return false;
  }
  /// The parameters of the effect; nothing if the scenario does not name it.
  virtual std::vector<effects::Knob> Knobs(const scenario::Scenario& /*scenario*/) const {
    return {};
  }
  /// The files of the effect itself.
  virtual void AddInputs(const scenario::Scenario& /*scenario*/,
                         std::vector<DeclaredInput>& /*inputs*/) const {}
  /// Loads the inputs of its stages in scene.plan. The patient, the presets and the previous
  /// effects are loaded. @throws InputError if a file is not readable or a setting is not allowed.
  virtual void Load(const scenario::Scenario& /*scenario*/, Scene& /*scene*/,
                    RunContext& /*context*/) const {}
  /// The computation of its stage in scene.plan that writes a port; null for stages at every image.
  /// @param scene  Must outlive it.
  virtual std::unique_ptr<const CoupledStage> NewStage(effects::PortRef /*writes*/,
                                                       const Scene& /*scene*/) const {
    return nullptr;
  }
};

/// In the order in which their stages run, and in which they are loaded.
std::vector<const CoupledEffect*> CoupledEffects();

namespace coupled {

// Each is defined in a file of its name.
const CoupledEffect& Breathing();
const CoupledEffect& Tools();
const CoupledEffect& NeedleForce();
const CoupledEffect& NeedleShape();
const CoupledEffect& ProbeForce();
const CoupledEffect& Tissue();
const CoupledEffect& CtSlice();
const CoupledEffect& BMode();

}  // namespace coupled

}  // namespace acus::simulation
