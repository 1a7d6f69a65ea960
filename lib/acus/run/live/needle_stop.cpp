#include "acus/run/live/needle_stop.h"

#include <algorithm>

#include "acus/data/volume/labels.h"

namespace acus::live {
namespace {

constexpr double kLongestWayMm = 100.0;  ///< Search length in one step.
constexpr double kLeastStepMm = 0.1;

}  // namespace

NeedleStop::NeedleStop(const forces::TissueLookup& tissue, double length_mm)
    : tissue_(tissue), length_mm_(length_mm), bone_(volume::LabelOf("bone")) {}

NeedleStop::Held NeedleStop::At(const Eigen::Vector3d& tip_mm,
                                const Eigen::Vector3d& axis) noexcept {
  const auto is_bone = [this](const Eigen::Vector3d& p) { return tissue_.At(p) == bone_; };
  const auto is_body = [this](const Eigen::Vector3d& p) { return tissue_.At(p) != 0; };
  const double ahead_mm = last_tip_mm_ ? std::max(0.0, (tip_mm - *last_tip_mm_).dot(axis)) : 0.0;
  const double step_mm = StepMm();
  Held held;
  if (const auto bone_mm = FirstMm(tip_mm, axis, ahead_mm + kIntoBoneMm + step_mm, is_bone)) {
    // In bone from the start, or sideways into it: no deeper, until it is withdrawn.
    held = {StopKind::kBone, std::clamp(*bone_mm - kIntoBoneMm, 0.0, ahead_mm)};
  }
  const Eigen::Vector3d hub_mm = tip_mm - length_mm_ * axis;
  if (auto skin_mm = FirstMm(hub_mm, axis, ahead_mm + step_mm, is_body)) {
    while (*skin_mm < ahead_mm + kLongestWayMm && is_body(hub_mm - *skin_mm * axis)) {
      *skin_mm += step_mm;
    }
    if (*skin_mm > held.beyond_mm) held = {StopKind::kHub, *skin_mm};
  }
  last_tip_mm_ = tip_mm - held.beyond_mm * axis;
  return held;
}

double NeedleStop::StepMm() const noexcept {
  return std::max(kLeastStepMm, tissue_.HalfVoxelMm());
}

template <typename IsThere>
std::optional<double> NeedleStop::FirstMm(const Eigen::Vector3d& end_mm,
                                          const Eigen::Vector3d& axis, double way_mm,
                                          const IsThere& is_there) const noexcept {
  const double nearest_mm = std::max(0.0, way_mm - kLongestWayMm);
  for (double behind_mm = way_mm;; behind_mm -= StepMm()) {
    behind_mm = std::max(nearest_mm, behind_mm);
    if (is_there(end_mm - behind_mm * axis)) return behind_mm;
    if (behind_mm <= nearest_mm) break;
  }
  return nearest_mm > 0.0 ? std::optional(nearest_mm) : std::nullopt;
}

}  // namespace acus::live
