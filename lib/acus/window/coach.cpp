#include "acus/window/coach.h"

#include <array>
#include <cmath>
#include <utility>

namespace acus::window {
namespace {

std::string MmText(double distance_mm) {
  return std::to_string(std::lround(std::abs(distance_mm))) + " mm";
}

/// "Tab selects the probe, Left moves it there." or, for a real hand: "slide the probe there."
std::string Remedy(const SteeredTool& tool, const std::string& name,
                   const Eigen::Vector3d& direction_in_ct, const std::string& by_hand) {
  if (!tool.is_virtual) return by_hand;
  const std::string key = KeyTowards(tool, direction_in_ct);
  return tool.is_selected ? key + " moves it there."
                          : "Tab selects the " + name + ", " + key + " moves it there.";
}

std::string OfContact(const CoachView& view) {
  if (view.now.probe_on_skin) return "";
  if (!view.gap_to_skin_mm) {
    return view.probe.is_virtual ? std::string("The probe does not face the patient: ") +
                                       (view.probe.is_selected ? "" : "Tab selects it, ") +
                                       "the right mouse button turns it."
                                 : "The probe does not face the patient: turn it to the skin.";
  }
  return "The probe is " + MmText(*view.gap_to_skin_mm) + " off the skin: " +
         Remedy(view.probe, "probe", view.ct_from_probe.col(1), "place it on the skin.");
}

std::string OfTarget(const CoachView& view) {
  const auto& at_mm = view.now.target_in_probe_mm;
  if (!at_mm || view.now.target_in_view) return "";
  if (std::abs(at_mm->z()) > view.half_thickness_mm) {
    const Eigen::Vector3d way = std::copysign(1.0, at_mm->z()) * view.ct_from_probe.col(2);
    return "The target is " + MmText(at_mm->z()) + " off the image plane: " +
           Remedy(view.probe, "probe", way, "slide or tilt the probe across its image.");
  }
  const double reach_mm = view.field.depth_mm;
  const bool is_deeper = view.field.Contains(at_mm->x() * reach_mm / at_mm->y(), reach_mm);
  if (at_mm->y() > reach_mm && is_deeper)
    return "The target is deeper than the image: D shows more.";
  const Eigen::Vector3d way = std::copysign(1.0, at_mm->x()) * view.ct_from_probe.col(0);
  return std::string("The target is beside the image, to the ") +
         (at_mm->x() > 0.0 ? "right: " : "left: ") +
         Remedy(view.probe, "probe", way, "slide the probe that way.");
}

std::string OfNeedle(const CoachView& view) {
  const auto& tip_mm = view.now.tip_in_probe_mm;
  if (!view.wants_plane || !tip_mm || view.now.needle_in_plane) return "";
  if (std::abs(tip_mm->z()) > view.half_thickness_mm) {
    const Eigen::Vector3d way = -std::copysign(1.0, tip_mm->z()) * view.ct_from_probe.col(2);
    return "The needle's tip is " + MmText(tip_mm->z()) +
           " off the image plane: " + Remedy(view.needle, "needle", way, "move it into the plane.");
  }
  return std::string("The needle crosses the image plane: ") +
         (!view.needle.is_virtual   ? "turn it until its shaft lies in the plane."
          : view.needle.is_selected ? "the right mouse button turns it into the plane."
                                    : "Tab selects it, the right mouse button turns it.");
}

}  // namespace

std::string KeyTowards(const SteeredTool& tool, const Eigen::Vector3d& direction_in_ct) {
  const Eigen::Vector3d in_device = tool.device_from_ct * direction_in_ct;
  const double along = tool.along_in_ct.dot(direction_in_ct);
  const std::array<std::pair<double, const char*>, 6> keys = {{{in_device.x(), "Right"},
                                                               {-in_device.x(), "Left"},
                                                               {in_device.y(), "Up"},
                                                               {-in_device.y(), "Down"},
                                                               {along, "Page Down"},
                                                               {-along, "Page Up"}}};
  const auto* best = &keys[0];
  for (const auto& key : keys) {
    if (key.first > best->first) best = &key;
  }
  return best->second;
}

std::string CoachLine(const CoachView& view) {
  if (view.switch_is_open) {
    return "No force until the switch is held: the device's button, the pedal or the space bar.";
  }
  if (view.has_probe) {
    if (!view.now.probe_seen) return "The probe is not seen: turn its marker to the camera.";
    if (const std::string line = OfContact(view); !line.empty()) return line;
    if (const std::string line = OfTarget(view); !line.empty()) return line;
  }
  if (!view.has_needle) return "";
  if (!view.now.needle_seen) return "The needle is not seen: turn its marker to the camera.";
  return OfNeedle(view);
}

}  // namespace acus::window
