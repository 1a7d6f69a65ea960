#include "acus/patient/phantom/hands/demonstration.h"

#include <algorithm>
#include <utility>

#include "acus/data/volume/labels.h"
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
constexpr double kThumbN = 12.0;
constexpr double kWithThumbMmPerS = 2.0;
constexpr double kBehindLigamentMm = 1.5;
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

/// Depths along the path at which the last ligament before the spinal canal begins and ends.
std::optional<std::pair<double, double>> LastLigament(const PatientField& field,
                                                      const InsertionPlan& plan) {
  const volume::Label ligament = volume::LabelOf("ligament");
  const volume::Label canal = volume::LabelOf("spinal_canal");
  constexpr double kStepMm = 0.1;
  double from_mm = 0.0, to_mm = 0.0;
  volume::Label before = 0;
  for (double depth_mm = 0.0; depth_mm < plan.length_mm(); depth_mm += kStepMm) {
    const volume::Label label = field.LabelAt(plan.entry_ct_mm + depth_mm * plan.direction);
    if (label == ligament && before != ligament) from_mm = depth_mm;
    if (label == ligament) to_mm = depth_mm + kStepMm;
    if (label == canal) break;
    before = label;
  }
  if (to_mm == 0.0) return std::nullopt;
  return std::pair(from_mm, to_mm);
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

SessionSettings FluidDemonstrationOf(const PatientField& field, const InsertionPlan& plan,
                                     const SessionSettings& settings,
                                     const FluidDemonstration& fluid) {
  SessionSettings out = DemonstrationOf(field, plan, settings);
  out.name = std::string(kDemonstration) + "_" + fluid.exercise;
  const auto at_target = std::ranges::find(out.needle, To::kTarget, &NeedleMove::to);
  at_target->hold_s = 1.0;
  NeedleMove press = Move(To::kTarget, kAdvanceMmPerS, fluid.hold_s);
  press.plunger_n = fluid.plunger_n;
  NeedleMove rest = Move(To::kTarget, kAdvanceMmPerS, 1.0);
  rest.plunger_n = 0.0;
  out.needle.insert(at_target + 1, {press, rest});
  return out;
}

std::optional<SessionSettings> EpiduralDemonstrationOf(const PatientField& field,
                                                       const InsertionPlan& plan,
                                                       const SessionSettings& settings) {
  const auto ligament = LastLigament(field, plan);
  if (!ligament) return std::nullopt;
  SessionSettings out = DemonstrationOf(field, plan, settings);
  out.name = std::string(kDemonstration) + "_epidural";
  out.needle.resize(2);  // Up to the skin.
  out.needle.push_back(ToDepth(ligament->first + 0.5, 0.5));
  NeedleMove through = ToDepth(ligament->second + kBehindLigamentMm, 1.0);
  through.speed_mm_per_s = kWithThumbMmPerS;
  through.plunger_n = kThumbN;
  out.needle.push_back(through);
  NeedleMove rest = through;
  rest.plunger_n = 0.0;
  rest.hold_s = kAtTargetS;
  out.needle.push_back(rest);
  out.needle.push_back(Move(To::kStart, kWithdrawMmPerS, 1.0));
  out.needle.back().breath = Breath::kRelease;
  return out;
}

}  // namespace acus::phantom
