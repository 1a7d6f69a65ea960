#include "acus/patient/phantom/hands/needle_script.h"

#include <algorithm>
#include <cmath>

#include "acus/patient/phantom/hands/hand_motion.h"

namespace acus::phantom {
namespace {

double DepthOf(const NeedleMove& move, const InsertionPlan& plan, const SessionSettings& settings) {
  switch (move.to) {
    case NeedleMove::To::kStart:
      return -settings.standoff_mm;
    case NeedleMove::To::kSkin:
      return 0.0;
    case NeedleMove::To::kBone:
      return plan.bone_depth_mm + settings.bone_press_mm;
    case NeedleMove::To::kTarget:
      return plan.length_mm();
    case NeedleMove::To::kDepth:
      return move.depth_mm;
  }
  ACUS_ASSERT(false);
}

}  // namespace

NeedleScript::NeedleScript(const InsertionPlan& plan, const SessionSettings& settings) {
  const auto angle = [&](const NeedleMove& move) {
    return move.aim == NeedleMove::Aim::kBone ? plan.bone_angle_rad.value_or(0.0) : 0.0;
  };
  now_ = {-settings.standoff_mm, settings.needle.empty() ? 0.0 : angle(settings.needle.front())};
  for (const NeedleMove& move : settings.needle) {
    if (move.to == NeedleMove::To::kBone && !plan.bone_angle_rad) continue;
    Command(move);
    if (angle(move) != now_.angle_rad) {
      redirect_times_s_.push_back(duration_s_);
      Go({now_.depth_mm, angle(move)},
         StrokeDurationS(angle(move) - now_.angle_rad, settings.turn_rad_per_s));
      redirected_times_s_.push_back(duration_s_);
    }
    const double depth = DepthOf(move, plan, settings);
    Go({depth, now_.angle_rad}, StrokeDurationS(depth - now_.depth_mm, move.speed_mm_per_s));
    if (move.to == NeedleMove::To::kTarget) target_times_s_.push_back(duration_s_);
    Go(now_, move.hold_s);
  }
}

void NeedleScript::Command(const NeedleMove& move) {
  using session::CommandKind;
  const std::int64_t time_ns = std::llround(1e9 * duration_s_);
  if (move.breath != NeedleMove::Breath::kAsBefore) {
    commands_.push_back({.time_ns = time_ns,
                         .kind = move.breath == NeedleMove::Breath::kHold
                                     ? CommandKind::kHoldBreath
                                     : CommandKind::kBreatheOn});
  }
  if (move.plunger_n) commands_.push_back({time_ns, CommandKind::kPlunger, *move.plunger_n});
}

void NeedleScript::Go(const NeedleState& to, double duration_s) {
  if (duration_s <= 0.0) return;
  strokes_.push_back({duration_s_, duration_s_ + duration_s, now_, to});
  duration_s_ += duration_s;
  now_ = to;
}

NeedleState NeedleScript::At(double time_s) const {
  const auto stroke = std::ranges::upper_bound(strokes_, time_s, {}, &Stroke::end_s);
  if (stroke == strokes_.end()) return now_;
  const double s = MinimumJerk((time_s - stroke->start_s) / (stroke->end_s - stroke->start_s));
  return {stroke->from.depth_mm + s * (stroke->to.depth_mm - stroke->from.depth_mm),
          stroke->from.angle_rad + s * (stroke->to.angle_rad - stroke->from.angle_rad)};
}

}  // namespace acus::phantom
