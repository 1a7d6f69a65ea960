// An effect that is coupled with others: tissue, needle, forces, breath and the images of the probe
// read each other's results by type. Plan, loader and step go by the list of these effects and name
// none of them. What stands alone is an effects::Effect.
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

/// A step in work, as one stage after the other sees it.
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
  /// Why there is nothing to do for a needle that is in no tissue.
  Sleep outside() const noexcept {
    return state.needle_seen ? Sleep::kNeedleOutside : Sleep::kNeedleUnseen;
  }
};

/// The work of a stage at every sample. Const: all that changes is in the State.
class CoupledStage {
 public:
  virtual ~CoupledStage() = default;
  virtual void Begin(State& /*state*/) const {}
  /// Real time: must not allocate, lock, log or throw. The same inputs give the same bits.
  /// @return  why there was nothing to do.
  virtual Sleep Step(StepFrame& frame) const noexcept = 0;
};

/// A kind of effect. One object for each, of static storage.
class CoupledEffect {
 public:
  virtual ~CoupledEffect() = default;

  /// Among the scenario's effects: "needle_force". Empty: what all of them share.
  virtual std::string_view key() const = 0;
  /// All its stages, whether the scenario calls for them or not, in the order in which they run.
  virtual std::vector<PlannedStage> Stages(const scenario::Scenario& scenario,
                                           bool breath_from_session) const = 0;
  /// What its stages write that are there for its own sake.
  virtual std::vector<effects::PortRef> Goals(const scenario::Scenario& /*scenario*/) const {
    return {};
  }
  /// What stages write that it works through, where another stage reads it.
  virtual std::vector<effects::PortRef> Helpers(const scenario::Scenario& /*scenario*/) const {
    return {};
  }
  /// True if the scenario has what one of its stages writes, for those that can do without.
  virtual bool Offers(const scenario::Scenario& /*scenario*/, effects::PortRef /*port*/) const {
    return false;
  }
  /// What can be coarser or finer in the scenario; nothing if it does not call for the effect.
  virtual std::vector<effects::Knob> Knobs(const scenario::Scenario& /*scenario*/) const {
    return {};
  }
  /// Its own files.
  virtual void AddInputs(const scenario::Scenario& /*scenario*/,
                         std::vector<DeclaredInput>& /*inputs*/) const {}
  /// What its stages in scene.plan need. The patient, the presets and the effects before it are
  /// loaded. @throws InputError if a file is not readable or a setting does not fit.
  virtual void Load(const scenario::Scenario& /*scenario*/, Scene& /*scene*/,
                    RunContext& /*context*/) const {}
  /// The work of its stage in scene.plan that writes a port; null for stages at every image.
  /// @param scene  Must outlive it.
  virtual std::unique_ptr<const CoupledStage> NewStage(effects::PortRef /*writes*/,
                                                       const Scene& /*scene*/) const {
    return nullptr;
  }
};

/// In the order in which their stages run, and in which they are loaded.
std::vector<const CoupledEffect*> CoupledEffects();

namespace coupled {

// One in each file.
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
