#include "acus/physics/forces/path/sample_gate.h"

#include <cmath>

namespace acus::forces {
namespace {

constexpr double kFarthestMm = 1e5;  // Coordinates beyond it are not positions in a room.

}  // namespace

SampleGate::Verdict SampleGate::Judge(double sample_time_s, bool valid,
                                      const Eigen::Vector3d& tip_in_ct_mm,
                                      const Eigen::Vector3d& axis_in_ct) noexcept {
  if (!std::isfinite(sample_time_s)) {
    ++num_rejected;
    return Verdict::kZero;
  }
  if (started && sample_time_s <= time_s) {
    ++num_time_back;
    return Verdict::kHold;
  }
  time_s = sample_time_s;
  if (!valid) return started ? Verdict::kHold : Verdict::kZero;
  const double axis_length = axis_in_ct.norm();
  if (!(axis_length > 1e-9 && axis_length < 1e9) || !tip_in_ct_mm.allFinite() ||
      !(tip_in_ct_mm.cwiseAbs().maxCoeff() <= kFarthestMm)) {
    ++num_rejected;
    return Verdict::kZero;
  }
  return Verdict::kStep;
}

double SampleGate::HeldShare(const ForceSettings& settings) const noexcept {
  const double late_s = time_s - valid_time_s - settings.invalid_hold_s;
  const double ramp_s = settings.invalid_ramp_s;
  return late_s <= 0.0 ? 1.0 : (late_s < ramp_s ? 1.0 - late_s / ramp_s : 0.0);
}

NeedleForce SampleGate::Held(const ForceSettings& settings) const noexcept {
  NeedleForce out = held;
  Scale(out, HeldShare(settings));
  out.event = NeedleEvent::kNone;
  return out;
}

}  // namespace acus::forces
