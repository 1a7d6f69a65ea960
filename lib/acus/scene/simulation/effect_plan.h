// The effect plan: exactly the stages that the scene's effects need, in order, and why.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "acus/scene/effects/ports.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::simulation {

/// A stage, in the plan or not. It runs at every sample or at every image.
struct PlannedStage {
  std::string_view name;
  std::string_view rate;  ///< "step" or "image".
  /// Data that must exist before: inputs, or outputs of other stages. It touches nothing else.
  std::vector<effects::PortRef> reads;
  std::vector<effects::PortRef> writes;
  std::string_view owner = {};  ///< Key of the effect that it belongs to; empty: shared by all.
  bool in = false;
  std::string reason = {};  ///< Why it is in or out.
  /// Keys of the scenario's effects that it serves, directly or through other stages.
  std::vector<std::string_view> effects = {};

  std::size_t number = 0;  ///< Its place in EffectPlan::stages().

  bool is_image() const { return rate == "image"; }
  bool Reads(effects::PortRef port) const { return std::ranges::find(reads, port) != reads.end(); }
  bool Writes(effects::PortRef port) const {
    return std::ranges::find(writes, port) != writes.end();
  }
};

/// An external input of stages in the plan.
struct PlannedInput {
  effects::PortRef port;       ///< As in PlannedStage::reads.
  std::filesystem::path file;  ///< Empty for what the session holds.
  std::string where;           ///< JSON pointer into the scenario: "/patient/ct"; or empty.
};

/// The inputs that the recording and the patient offer.
struct AvailableInputs {
  bool needle_poses = false;
  bool probe_poses = false;
  bool breath = false;  ///< The session holds the patient's breath.
};

class EffectPlan {
 public:
  const std::vector<PlannedStage>& stages() const { return stages_; }

  /// The first stage that writes `port`, in the plan or not. @pre there is one.
  const PlannedStage& WriterOf(effects::PortRef port) const;

  /// True if a stage in the plan writes `port`.
  bool Writes(effects::PortRef port) const;

  /// True if a stage in the plan writes `written` and reads `data` for it.
  bool Reads(effects::PortRef written, effects::PortRef data) const;

  /// True if a stage at every sample is in the plan and reads `data`.
  bool StepReads(effects::PortRef data) const;

  /// The external inputs of the stages in the plan; all of them are given. Nothing else is loaded.
  const std::vector<PlannedInput>& inputs() const { return inputs_; }

  /// True if any stage in the plan reads `data`. Other data is not loaded.
  bool Needs(effects::PortRef data) const;

  /// True if the patient's breath comes from the session, not from the scenario.
  bool breath_from_session() const { return breath_from_session_; }

 private:
  friend EffectPlan PlanEffects(const scenario::Scenario&, const AvailableInputs&);
  std::vector<PlannedStage> stages_;
  std::vector<PlannedInput> inputs_;
  bool breath_from_session_ = false;
};

/// Selects the stages whose outputs the scenario's effects need, directly or through other stages.
/// Opens no file.
/// @throws InputError naming every input that such an effect needs and that is not given.
EffectPlan PlanEffects(const scenario::Scenario& scenario, const AvailableInputs& available);

/// @throws InputError naming every file that a stage in the plan reads and that does not exist,
///     with the stages and effects that need it. Files that no stage reads need not exist.
void RequireFiles(const EffectPlan& plan, const scenario::Scenario& scenario);

}  // namespace acus::simulation
