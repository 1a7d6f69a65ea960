#include "acus/patient/phantom/hands/demonstration.h"

#include <algorithm>

#include "acus/patient/phantom/hands/probe_script.h"

namespace acus::phantom {
namespace {

using To = NeedleMove::To;
using Breath = NeedleMove::Breath;

constexpr double kPressedMm = 1.0;      ///< The probe into the skin, so that it is in contact.
constexpr double kReadingDepthS = 3.0;  ///< The probe rests with the target in its image.
constexpr double kShallowMm = 10.0;
constexpr double kInAndOutMm = 4.0;  ///< Less than what counts as a withdrawal.
constexpr int kTimesInAndOut = 3;
constexpr double kAdvanceMmPerS = 10.0;
constexpr double kAtTargetS = 3.0;
constexpr double kWithdrawMmPerS = 40.0;
/// From the middle of the image: within a linear array of 38 mm, the narrowest preset.
constexpr double kTargetAsideMm = 12.0;

NeedleMove Move(To to, double speed_mm_per_s, double hold_s) {
  return {.to = to, .speed_mm_per_s = speed_mm_per_s, .hold_s = hold_s};
}

NeedleMove ToDepth(double depth_mm, double hold_s) {
  NeedleMove move = Move(To::kDepth, kAdvanceMmPerS, hold_s);
  move.depth_mm = depth_mm;
  return move;
}

/// The probe farther from the needle, until the target is below its face; where it is, if there is
/// no skin farther on.
ProbeScript OverTarget(const PatientField& field, const InsertionPlan& plan,
                       const ProbeScript& probe) {
  const ProbePath path(field, plan, probe);
  const Eigen::Isometry3d at_rest = path.CtFromProbe(probe.land_s + probe.sweep_s, 0.0, 0.0);
  const double aside_mm = (at_rest.inverse() * plan.target_ct_mm).x();
  ProbeScript over = probe;
  over.ahead_mm += std::max(0.0, aside_mm - kTargetAsideMm);
  try {
    ProbePath(field, plan, over);
  } catch (const NoAnswerError&) {
    return probe;
  }
  return over;
}

}  // namespace

SessionSettings DemonstrationOf(const PatientField& field, const InsertionPlan& plan,
                                const SessionSettings& settings) {
  SessionSettings out = settings;
  out.name = kDemonstration;
  out.probe = OverTarget(field, plan, settings.probe);
  out.probe.gap_mm = -kPressedMm;
  out.needle = {
      Move(To::kStart, kAdvanceMmPerS, out.probe.land_s + out.probe.sweep_s + kReadingDepthS)};
  out.needle.push_back(Move(To::kSkin, kWithdrawMmPerS, 0.5));
  out.needle.back().breath = Breath::kHold;
  const double shallow_mm = std::min(kShallowMm, 0.5 * plan.length_mm());
  out.needle.push_back(ToDepth(shallow_mm, 0.5));
  for (int i = 0; i < kTimesInAndOut; ++i) {
    out.needle.push_back(ToDepth(shallow_mm - kInAndOutMm, 0.0));
    out.needle.push_back(ToDepth(shallow_mm, 0.0));
  }
  out.needle.push_back(Move(To::kTarget, kAdvanceMmPerS, kAtTargetS));
  out.needle.push_back(Move(To::kStart, kWithdrawMmPerS, 0.5));
  out.needle.push_back(Move(To::kStart, kWithdrawMmPerS, 1.0));
  out.needle.back().breath = Breath::kRelease;
  return out;
}

}  // namespace acus::phantom
