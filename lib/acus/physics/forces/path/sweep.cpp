#include "acus/physics/forces/path/sweep.h"

namespace acus::forces {

bool IsSwept(const NeedleTrack& track, const ForceSettings& settings, const NeedleInput& input,
             const Eigen::Vector3d& from_axis, SweptWay& out) noexcept {
  if (!track.started) return false;
  SampleGate gate = track;
  if (gate.Judge(input) != SampleGate::Verdict::kStep) return false;
  if (!(gate.HeldShare(settings) > 0.0)) return false;  // It may have been anywhere.
  const double length_mm = (input.tip_in_ct_mm - track.tip_in_ct_mm).norm();
  if (!(length_mm > SweepLimits::kResolvedMm && length_mm <= SweepLimits::kFarthestMm)) {
    return false;
  }
  out = {.to = input,
         .from_s = track.time_s,
         .from_mm = track.tip_in_ct_mm,
         .from_axis = from_axis,
         .length_mm = length_mm};
  return true;
}

}  // namespace acus::forces
