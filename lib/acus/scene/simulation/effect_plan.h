// The effect plan: just the stages that the scene's effects need, in order, and why.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "acus/scene/effects/ports.h"
#include "acus/scene/scenario/scenario.h"

namespace acus::simulation {

/// A piece of work. kStep stages run at every sample, kImage stages at every image.
enum class StageId {
  kBreathing,
  kNeedlePose,
  kTissueLookup,
  kTissueContact,
  kNeedleForce,
  kNeedleShape,
  kProbeForce,
  kProbePose,
  kDeformation,
  kCtSlice,
  kUltrasound,
  kEnd,  ///< No stage: it comes after the last one.
};
inline constexpr int kNumStages = static_cast<int>(StageId::kEnd);

/// Stages of Scenario::listed come after those: two numbers for each effect, by its place in the
/// list.
inline constexpr int kMaxListed = 8;
inline constexpr int kMaxStages = kNumStages + 2 * kMaxListed;
constexpr StageId StepStageOf(std::size_t other) {
  return static_cast<StageId>(kNumStages + 2 * static_cast<int>(other));
}
constexpr StageId ImageStageOf(std::size_t other) {
  return static_cast<StageId>(kNumStages + 2 * static_cast<int>(other) + 1);
}

/// A stage in the plan, or one that is left out.
struct PlannedStage {
  StageId id;
  std::string_view name;
  std::string_view rate;  ///< "step" or "image".
  /// Data that must be there before: inputs or what other stages write. It touches nothing else.
  std::vector<effects::PortRef> reads;
  std::vector<effects::PortRef> writes;
  bool in = false;
  std::string reason;  ///< Why it is in or out.
  /// Keys of the scenario's effects that it works for, directly or through other stages.
  std::vector<std::string_view> effects = {};
};

/// Something from outside that stages in the plan read.
struct PlannedInput {
  effects::PortRef port;       ///< As in PlannedStage::reads.
  std::filesystem::path file;  ///< Empty for what the session holds.
  std::string where;           ///< JSON pointer into the scenario: "/patient/ct"; or empty.
};

/// What the recording and the patient can give.
struct AvailableInputs {
  bool needle_poses = false;
  bool probe_poses = false;
  bool breath = false;  ///< The session says how the patient breathes.
};

class EffectPlan {
 public:
  const std::vector<PlannedStage>& stages() const { return stages_; }
  bool Has(StageId id) const;
  const PlannedStage& Of(StageId id) const;

  /// True if that stage is in the plan and reads `data`.
  bool Reads(StageId id, effects::PortRef data) const;

  /// What the stages in the plan read from outside; all of it is there. Nothing else is loaded.
  const std::vector<PlannedInput>& inputs() const { return inputs_; }

  /// True if any stage in the plan reads `data`. What nobody reads is not loaded.
  bool Needs(effects::PortRef data) const;

  /// True if the patient breathes as the session says, not as the scenario does.
  bool breath_from_session() const { return breath_from_session_; }

 private:
  friend EffectPlan PlanEffects(const scenario::Scenario&, const AvailableInputs&);
  std::vector<PlannedStage> stages_;
  std::vector<PlannedInput> inputs_;
  bool breath_from_session_ = false;
};

/// Picks the stages whose outputs the called-for effects need, directly or through other stages.
/// Looks at no file.
/// @throws InputError naming every input that a called-for effect needs and that is not given.
EffectPlan PlanEffects(const scenario::Scenario& scenario, const AvailableInputs& available);

/// @throws InputError naming every file that a stage in the plan reads and that is not there, with
///     the stages and effects that it is for. Files that no stage reads need not exist.
void RequireFiles(const EffectPlan& plan, const scenario::Scenario& scenario);

}  // namespace acus::simulation
