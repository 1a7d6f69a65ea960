#include "tissue/sample_gate.h"

#include <cmath>

namespace acus::tissue {
namespace {

constexpr double kFarthestMm = 1e5;  // Coordinates beyond it are not positions in a room.

}  // namespace

SampleGate::Verdict SampleGate::Judge(const ToolSample& sample) noexcept {
  if (!std::isfinite(sample.time_s)) {
    ++num_rejected;
    return Verdict::kZero;
  }
  if (started && sample.time_s <= time_s) {
    ++num_time_back;
    return Verdict::kHold;
  }
  time_s = sample.time_s;
  if (!sample.needle_valid) return started ? Verdict::kHold : Verdict::kZero;
  const double axis_length = sample.axis_in_ct.norm();
  if (!(axis_length > 1e-9 && axis_length < 1e9) || !sample.tip_in_ct_mm.allFinite() ||
      !(sample.tip_in_ct_mm.cwiseAbs().maxCoeff() <= kFarthestMm)) {
    ++num_rejected;
    return Verdict::kZero;
  }
  return Verdict::kStep;
}

forces::NeedleForce SampleGate::Held(const forces::ForceSettings& settings) const noexcept {
  const double late_s = time_s - valid_time_s - settings.invalid_hold_s;
  const double ramp_s = settings.invalid_ramp_s;
  forces::NeedleForce out = held;
  Scale(out, late_s <= 0.0 ? 1.0 : (late_s < ramp_s ? 1.0 - late_s / ramp_s : 0.0));
  out.event = forces::NeedleEvent::kNone;
  return out;
}

void SampleGate::Accept(const ToolSample& sample, const forces::NeedleForce& force) noexcept {
  started = true;
  valid_time_s = sample.time_s;
  held = force;
}

forces::NeedleEvent FirstOf(forces::NeedleEvent a, forces::NeedleEvent b) noexcept {
  using enum forces::NeedleEvent;
  for (const forces::NeedleEvent event :
       {kBoneContact, kPuncture, kContact, kInterface, kBoneRelease, kWithdrawal}) {
    if (a == event || b == event) return event;
  }
  return kNone;
}

void Scale(forces::NeedleForce& force, double share) noexcept {
  force.puncture_n *= share;
  force.cutting_n *= share;
  force.friction_n *= share;
  force.bone_n *= share;
  force.lateral_n *= share;
  force.force_in_ct_n *= share;
}

void LimitTo(forces::NeedleForce& force, double largest_n) noexcept {
  const double size_n = force.force_in_ct_n.norm();
  if (size_n > largest_n) Scale(force, largest_n / size_n);
}

}  // namespace acus::tissue
