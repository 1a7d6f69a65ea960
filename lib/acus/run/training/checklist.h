// Checklists whose steps are ticked off automatically during a session.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "acus/run/training/jiggle_meter.h"
#include "acus/run/training/situation.h"

namespace acus::training {

/// The condition of a step. Names in exercise files: "probe_on_skin", "target_in_view", ...
enum class StepCondition {
  kProbeOnSkin,
  kTargetInView,
  kNeedleInPlane,  ///< Tip and shaft, in tissue or not.
  kNeedleInTissue,
  kBreathHeld,
  kTargetReached,
  kNeedleWithdrawn,   ///< Out of tissue, after it was in it by kLeastInsertionMm.
  kStructuresSpared,  ///< At the target or withdrawn without an entry; fails at the first entry.
  kNeedleSeen,        ///< The tracker sees it.
  kNeedleAtSkin,      ///< Tissue begins at most 3 mm ahead of the tip, or the tip is in it.
  kNeedleJiggled,     ///< Moved back and forth in tissue and in the image plane; see JiggleMeter.
  kPositionChecked,   ///< Breath held, tip at the target, needle and target in the image.
  kPlungerPressed,    ///< By kLeastThumbN or more, with the tip in tissue.
  kPlungerPulled,     ///< The same; a stylet is removed so.
};
/// Force on a plunger or a stylet that counts as pressed or pulled.
inline constexpr double kLeastThumbN = 1.0;

std::string_view NameOf(StepCondition condition);
/// Nothing for an unknown name.
std::optional<StepCondition> StepConditionOf(std::string_view name);

struct ChecklistStep {
  std::string text;
  StepCondition when = StepCondition::kProbeOnSkin;
  double for_s = 0.0;  ///< The condition has to hold for this time without interruption.
  std::string hint;    ///< May be empty.
};

struct Checklist {
  bool in_order = true;  ///< A step can be done only after those before it.
  std::vector<ChecklistStep> steps;
};

enum class StepState { kOpen, kDone, kFailed };
/// "open", "done", "failed".
std::string_view NameOf(StepState state);

struct StepResult {
  std::string text;
  StepState state = StepState::kOpen;
  std::int64_t time_ns = 0;  ///< Session time when it was done or failed.
};

/// A tip that has been in tissue is withdrawn only after it was this far from where it came in:
/// tremor at the skin is no withdrawal.
inline constexpr double kLeastInsertionMm = 2.0;

/// Ticks steps off, sample by sample. A step that is done or failed does not change any more.
class ChecklistMeter {
 public:
  explicit ChecklistMeter(Checklist checklist);

  /// @param entered_avoided  The tip has been in a structure that is to be spared.
  void Add(std::int64_t time_ns, const Situation& now, bool entered_avoided);
  const std::vector<StepResult>& results() const { return results_; }

 private:
  bool Holds(StepCondition condition, const Situation& now, bool entered_avoided) const;

  Checklist checklist_;
  std::vector<StepResult> results_;
  std::vector<std::optional<std::int64_t>> since_ns_;  ///< Since when the condition holds.
  void NoteTissue(const Situation& now);

  std::optional<Eigen::Vector3d> entry_mm_;  ///< The first place of the tip in tissue.
  bool was_inserted_ = false;
  JiggleMeter jiggle_;  ///< Motion of the tip while the needle is in the image plane.
};

/// The first open step; nothing if there is none.
std::optional<std::size_t> NextStep(std::span<const StepResult> steps);

/// The times of hints: at once in the first trial, (trial - 1) x wait_s after a step became the
/// next one in later ones, and not at all after `trials` trials.
struct HintOptions {
  bool coach = true;  ///< The window names the obstacle.
  int trials = 3;     ///< 0: no hints.
  double wait_s = 10.0;
};
bool ShowsHint(const HintOptions& options, int trial, double waiting_s);

}  // namespace acus::training
