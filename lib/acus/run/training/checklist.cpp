#include "acus/run/training/checklist.h"

#include <algorithm>
#include <array>
#include <utility>

namespace acus::training {
namespace {

constexpr std::array<std::string_view, 14> kConditionNames = {
    "probe_on_skin",  "target_in_view",   "needle_in_plane",   "needle_in_tissue", "breath_held",
    "target_reached", "needle_withdrawn", "structures_spared", "needle_seen",      "needle_at_skin",
    "needle_jiggled", "position_checked", "plunger_pressed",   "plunger_pulled"};

}  // namespace

std::string_view NameOf(StepCondition condition) {
  return kConditionNames[static_cast<std::size_t>(condition)];
}

std::optional<StepCondition> StepConditionOf(std::string_view name) {
  const auto found = std::ranges::find(kConditionNames, name);
  if (found == kConditionNames.end()) return std::nullopt;
  return static_cast<StepCondition>(found - kConditionNames.begin());
}

std::string_view NameOf(StepState state) {
  constexpr std::array<std::string_view, 3> kNames = {"open", "done", "failed"};
  return kNames[static_cast<std::size_t>(state)];
}

ChecklistMeter::ChecklistMeter(Checklist checklist)
    : checklist_(std::move(checklist)), since_ns_(checklist_.steps.size()) {
  for (const ChecklistStep& step : checklist_.steps) results_.push_back({.text = step.text});
}

bool ChecklistMeter::Holds(StepCondition condition, const Situation& now,
                           bool entered_avoided) const {
  const bool withdrawn = was_inserted_ && now.needle_seen && !now.needle_in_tissue;
  switch (condition) {
    case StepCondition::kProbeOnSkin:
      return now.probe_on_skin;
    case StepCondition::kTargetInView:
      return now.probe_on_skin && now.target_in_view;
    case StepCondition::kNeedleInPlane:
      return now.needle_in_plane;
    case StepCondition::kNeedleInTissue:
      return now.needle_in_tissue;
    case StepCondition::kBreathHeld:
      return now.breath_held;
    case StepCondition::kTargetReached:
      return now.target_reached;
    case StepCondition::kNeedleWithdrawn:
      return withdrawn;
    case StepCondition::kStructuresSpared:
      return !entered_avoided && (now.target_reached || withdrawn);
    case StepCondition::kNeedleSeen:
      return now.needle_seen;
    case StepCondition::kNeedleAtSkin:
      return now.needle_at_skin || now.needle_in_tissue;
    case StepCondition::kNeedleJiggled:
      return jiggle_.jiggled();
    case StepCondition::kPositionChecked:
      return now.breath_held && now.target_reached && now.needle_in_plane && now.target_in_view;
    case StepCondition::kPlungerPressed:
      return now.needle_in_tissue && now.plunger_n >= kLeastThumbN;
    case StepCondition::kPlungerPulled:
      return now.needle_in_tissue && now.plunger_n <= -kLeastThumbN;
  }
  return false;
}

void ChecklistMeter::NoteTissue(const Situation& now) {
  if (!now.needle_in_tissue || !now.tip_mm) return;
  if (!entry_mm_) entry_mm_ = *now.tip_mm;
  was_inserted_ = was_inserted_ || (*now.tip_mm - *entry_mm_).norm() >= kLeastInsertionMm;
}

void ChecklistMeter::Add(std::int64_t time_ns, const Situation& now, bool entered_avoided) {
  NoteTissue(now);
  if (now.tip_mm && now.needle_in_tissue && now.needle_in_plane) {
    jiggle_.Add(time_ns, *now.tip_mm);
  } else {
    jiggle_ = {};
  }
  bool may_be_next = true;
  for (std::size_t i = 0; i < results_.size(); ++i) {
    StepResult& result = results_[i];
    const ChecklistStep& step = checklist_.steps[i];
    const bool spares = step.when == StepCondition::kStructuresSpared;
    if (spares && entered_avoided && result.state != StepState::kFailed) {
      result.state = StepState::kFailed;  // Also if it was done before.
      result.time_ns = time_ns;
    }
    if (result.state != StepState::kOpen) continue;
    if ((checklist_.in_order && !may_be_next) || !Holds(step.when, now, entered_avoided)) {
      since_ns_[i].reset();
    } else {
      if (!since_ns_[i]) since_ns_[i] = time_ns;
      if (1e-9 * static_cast<double>(time_ns - *since_ns_[i]) >= step.for_s) {
        result.state = StepState::kDone;
        result.time_ns = time_ns;
      }
    }
    // A step about structures to spare is decided at the end: it blocks no later step.
    may_be_next = may_be_next && (result.state != StepState::kOpen || spares);
  }
}

std::optional<std::size_t> NextStep(std::span<const StepResult> steps) {
  const auto next = std::ranges::find(steps, StepState::kOpen, &StepResult::state);
  if (next == steps.end()) return std::nullopt;
  return static_cast<std::size_t>(next - steps.begin());
}

bool ShowsHint(const HintOptions& options, int trial, double waiting_s) {
  return trial <= options.trials && waiting_s >= (trial - 1) * options.wait_s;
}

}  // namespace acus::training
