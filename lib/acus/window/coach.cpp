#include "acus/window/coach.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "acus/base/translation/translation.h"

namespace acus::window {
namespace {

using training::StepCondition;
using translation::Marked;
using translation::Translated;

/// Deeper than a probe compresses tissue.
constexpr double kDeepestProbeMm = 15.0;

std::string MmText(double distance_mm) {
  return std::to_string(std::lround(std::abs(distance_mm))) + " mm";
}

/// "Tab selects the probe, Left moves it there." or, for a real hand: "slide the probe there."
std::string Remedy(const SteeredTool& tool, bool is_probe, const Eigen::Vector3d& direction_in_ct,
                   const std::string& by_hand) {
  if (!tool.is_virtual) return by_hand;
  const std::string key = Translated(KeyTowards(tool, direction_in_ct));
  if (tool.is_selected) return Translated("{1} moves it there.", {key});
  return is_probe ? Translated("Tab selects the probe, {1} moves it there.", {key})
                  : Translated("Tab selects the needle, {1} moves it there.", {key});
}

std::string AdvanceText(const SteeredTool& needle) {
  const std::string key = Translated(Marked("Page Down"));
  return !needle.is_virtual   ? Translated("Advance the needle.")
         : needle.is_selected ? Translated("{1} advances the needle.", {key})
                              : Translated("Tab selects the needle, {1} advances it.", {key});
}

std::string WithdrawText(const SteeredTool& needle) {
  const std::string key = Translated(Marked("Page Up"));
  return !needle.is_virtual   ? Translated("Withdraw the needle.")
         : needle.is_selected ? Translated("{1} withdraws the needle.", {key})
                              : Translated("Tab selects the needle, {1} withdraws it.", {key});
}

std::string OfContact(const CoachView& view) {
  if (view.probe_depth_mm > kDeepestProbeMm) {
    return Translated(
        "The probe is {1} below the skin: {2}",
        {MmText(view.probe_depth_mm), Remedy(view.probe, true, -view.ct_from_probe.col(1),
                                             Translated("draw it back to the skin."))});
  }
  if (view.now.probe_on_skin) return "";
  if (!view.gap_to_skin_mm) {
    return !view.probe.is_virtual
               ? Translated("The probe does not face the patient: turn it to the skin.")
           : view.probe.is_selected
               ? Translated("The probe does not face the patient: the right mouse button turns it.")
               : Translated(
                     "The probe does not face the patient: Tab selects it, the right mouse button "
                     "turns it.");
  }
  return Translated(
      "The probe is {1} off the skin: {2}",
      {MmText(*view.gap_to_skin_mm),
       Remedy(view.probe, true, view.ct_from_probe.col(1), Translated("place it on the skin."))});
}

std::string OfTarget(const CoachView& view) {
  const auto& at_mm = view.now.target_in_probe_mm;
  if (!at_mm || view.now.target_in_view) return "";
  if (std::abs(at_mm->z()) > view.half_thickness_mm) {
    const Eigen::Vector3d way = std::copysign(1.0, at_mm->z()) * view.ct_from_probe.col(2);
    return Translated(
        "The target is {1} off the image plane: {2}",
        {MmText(at_mm->z()),
         Remedy(view.probe, true, way, Translated("slide or tilt the probe across its image."))});
  }
  const double reach_mm = view.field.depth_mm;
  const bool is_deeper = view.field.Contains(at_mm->x() * reach_mm / at_mm->y(), reach_mm);
  if (at_mm->y() > reach_mm && is_deeper) {
    return Translated("The target is deeper than the image: D shows more.");
  }
  const Eigen::Vector3d way = std::copysign(1.0, at_mm->x()) * view.ct_from_probe.col(0);
  const std::string remedy = Remedy(view.probe, true, way, Translated("slide the probe that way."));
  return at_mm->x() > 0.0
             ? Translated("The target is beside the image, to the right: {1}", {remedy})
             : Translated("The target is beside the image, to the left: {1}", {remedy});
}

std::string OfNeedle(const CoachView& view) {
  const auto& tip_mm = view.now.tip_in_probe_mm;
  if (!view.wants_plane || !tip_mm || view.now.needle_in_plane) return "";
  if (std::abs(tip_mm->z()) > view.half_thickness_mm) {
    const Eigen::Vector3d way = -std::copysign(1.0, tip_mm->z()) * view.ct_from_probe.col(2);
    return Translated("The needle's tip is {1} off the image plane: {2}",
                      {MmText(tip_mm->z()),
                       Remedy(view.needle, false, way, Translated("move it into the plane."))});
  }
  return !view.needle.is_virtual
             ? Translated(
                   "The needle crosses the image plane: turn it until its shaft lies in the "
                   "plane.")
         : view.needle.is_selected
             ? Translated(
                   "The needle crosses the image plane: the right mouse button turns it into "
                   "the plane.")
             : Translated(
                   "The needle crosses the image plane: Tab selects it, the right mouse "
                   "button turns it.");
}

/// The part of the needle's distance from the target that aiming changes: across the needle, and in
/// the image plane where the needle must stay in it.
Eigen::Vector3d BesideTarget(const CoachView& view) {
  const Eigen::Vector3d& way = *view.tip_to_target_in_ct_mm;
  const Eigen::Vector3d& along = view.needle.along_in_ct;
  Eigen::Vector3d beside = way - way.dot(along) * along;
  if (view.wants_plane && view.has_probe) {
    const Eigen::Vector3d normal = view.ct_from_probe.col(2);
    beside -= beside.dot(normal) * normal;
  }
  return beside;
}

std::string OfAim(const CoachView& view) {
  if (!view.tip_to_target_in_ct_mm || view.now.target_reached) return "";
  const double ahead_mm = view.tip_to_target_in_ct_mm->dot(view.needle.along_in_ct);
  const Eigen::Vector3d beside = BesideTarget(view);
  const double beside_mm = beside.norm();
  if (!view.now.needle_in_tissue) {
    if (beside_mm <= std::max(1.0, 0.5 * view.target_radius_mm)) return "";
    return Translated("The needle's line misses the target by {1}: {2}",
                      {MmText(beside_mm), Remedy(view.needle, false, beside / beside_mm,
                                                 Translated("shift or turn the needle."))});
  }
  if (ahead_mm < -view.target_radius_mm) {
    return Translated("The tip is {1} beyond the target: {2}",
                      {MmText(ahead_mm), WithdrawText(view.needle)});
  }
  if (beside_mm <= 1.5 * view.target_radius_mm) return "";
  return Translated("The needle's line misses the target by {1}: {2}",
                    {MmText(beside_mm), WithdrawText(view.needle)});
}

}  // namespace

std::string KeyTowards(const SteeredTool& tool, const Eigen::Vector3d& direction_in_ct) {
  const Eigen::Vector3d in_device = tool.device_from_ct * direction_in_ct;
  const double along = tool.along_in_ct.dot(direction_in_ct);
  const std::array<std::pair<double, const char*>, 6> keys = {{{in_device.x(), Marked("Right")},
                                                               {-in_device.x(), Marked("Left")},
                                                               {in_device.y(), Marked("Up")},
                                                               {-in_device.y(), Marked("Down")},
                                                               {along, Marked("Page Down")},
                                                               {-along, Marked("Page Up")}}};
  const auto* best = &keys[0];
  for (const auto& key : keys) {
    if (key.first > best->first) best = &key;
  }
  return best->second;
}

std::string CoachLine(const CoachView& view) {
  if (view.switch_is_open) {
    return Translated(
        "No force until the switch is held: the device's button, the pedal or the space bar.");
  }
  if (view.has_probe) {
    if (!view.now.probe_seen)
      return Translated("The probe is not seen: turn its marker to the camera.");
    if (const std::string line = OfContact(view); !line.empty()) return line;
    if (const std::string line = OfTarget(view); !line.empty()) return line;
  }
  if (!view.has_needle) return "";
  if (!view.now.needle_seen)
    return Translated("The needle is not seen: turn its marker to the camera.");
  if (const std::string line = OfNeedle(view); !line.empty()) return line;
  return OfAim(view);
}

std::string HowTo(const CoachView& view) {
  if (!view.next) return "";
  switch (*view.next) {
    case StepCondition::kBreathHeld:
    case StepCondition::kPositionChecked:
      return view.breath_held ? "" : Translated("B holds the breath.");
    case StepCondition::kNeedleWithdrawn:
      return WithdrawText(view.needle);
    case StepCondition::kNeedleJiggled:
      if (!view.now.needle_in_tissue) return AdvanceText(view.needle);
      return view.needle.is_virtual ? Translated("Page Down and Page Up, in turn, jiggle it.")
                                    : Translated("Move it back and forth.");
    case StepCondition::kNeedleAtSkin:
    case StepCondition::kNeedleInTissue:
    case StepCondition::kStructuresSpared:
    case StepCondition::kTargetReached:
      return view.now.target_reached ? Translated("Hold the needle still.")
                                     : AdvanceText(view.needle);
    case StepCondition::kPlungerPressed:
      return Translated("I presses the plunger.");
    case StepCondition::kPlungerPulled:
      return Translated("Shift+I pulls the plunger, or removes the stylet.");
    case StepCondition::kProbeOnSkin:
    case StepCondition::kTargetInView:
    case StepCondition::kNeedleInPlane:
    case StepCondition::kNeedleSeen:
      return "";
  }
  return "";
}

}  // namespace acus::window
