#include "acus/scene/effects/view_3d/tissue_under_tools.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/parallel.h"

namespace acus::effects {
namespace {

using volume_rendering::PressedTissue;

constexpr double kReachMm = 60.0;
constexpr double kLookEveryMm = 10.0;
constexpr double kPressedMm = 0.1;
constexpr double kFinestMm = 1.0;
constexpr double kCoarsestMm = 8.0;
/// The tolerance of BreathingRest.
constexpr double kBreathToleranceMm = 0.02;

/// The part of the reach that is pressed, with a margin.
Eigen::AlignedBox3d PressedPart(const PressedTissue::Breathed& breathed,
                                const Eigen::AlignedBox3d& reach, int num_threads) {
  // On a grid that is the same for every reach: fewer tools never find more.
  const Eigen::Array3d first = (reach.min().array() / kLookEveryMm).ceil();
  const Eigen::Array3d last = (reach.max().array() / kLookEveryMm).floor();
  const Eigen::Array3i looks = (last - first).cast<int>() + 1;
  std::vector<Eigen::AlignedBox3d> of_slice(static_cast<std::size_t>(looks[2]));
  ParallelFor(looks[2], num_threads, [&](int k) {
    for (int j = 0; j < looks[1]; ++j) {
      for (int i = 0; i < looks[0]; ++i) {
        const Eigen::Vector3d place = kLookEveryMm * (first.matrix() + Eigen::Vector3d(i, j, k));
        const Eigen::Vector3d offset = breathed(place, place) - place;
        if (offset.norm() > kPressedMm) of_slice[static_cast<std::size_t>(k)].extend(place);
      }
    }
  });
  Eigen::AlignedBox3d pressed;
  for (const Eigen::AlignedBox3d& box : of_slice) pressed.extend(box);
  if (pressed.isEmpty()) return pressed;
  return {pressed.min().array() - kLookEveryMm, pressed.max().array() + kLookEveryMm};
}

}  // namespace

Eigen::AlignedBox3d ReachOf(const ToolsOnTissue& tools) {
  Eigen::AlignedBox3d box;
  if (tools.needle) {
    const image::NeedleInImage& needle = *tools.needle;
    box.extend(needle.tip_in_ct_mm);
    // A hub is never in tissue: the third of the shaft next to it is not searched.
    box.extend(needle.tip_in_ct_mm - 0.67 * needle.length_mm * needle.axis_in_ct);
    for (int i = 0; i < needle.shape.num_points; ++i) box.extend(needle.shape.At(i));
  }
  if (tools.ct_from_probe) {  // Without a preset it is a fingertip.
    const double half_mm =
        tools.probe == nullptr ? 0.0 : 0.5 * acoustics::FaceLengthMm(*tools.probe);
    box.extend(*tools.ct_from_probe * Eigen::Vector3d(-half_mm, 0.0, 0.0));
    box.extend(*tools.ct_from_probe * Eigen::Vector3d(half_mm, 0.0, 0.0));
    box.extend(*tools.ct_from_probe * Eigen::Vector3d(0.0, kReachMm, 0.0));
  }
  if (box.isEmpty() || !box.min().allFinite() || !box.max().allFinite()) return {};
  return {box.min().array() - kReachMm, box.max().array() + kReachMm};
}

PressedTissue PressedIn(const slicing::RestMap& rest, const breathing::MotionMap* breath,
                        const Eigen::AlignedBox3d& reach, const PressedDetail& detail,
                        int breath_iterations) {
  if (reach.isEmpty()) return {};
  const bool moves = breath != nullptr && breath->moves();
  const math::InverseSettings inverse{.max_iterations = breath_iterations,
                                      .tolerance_mm = kBreathToleranceMm};
  const PressedTissue::Breathed breathed = [&](const Eigen::Vector3d& world_mm,
                                               const Eigen::Vector3d&) -> Eigen::Vector3d {
    const Eigen::Vector3d all_mm = rest.RestInCtMm(world_mm, world_mm);
    if (!moves) return all_mm;
    const Eigen::Vector3d breath_mm = breath->RestOf(world_mm, world_mm, inverse).rest_mm;
    if (all_mm == breath_mm) return world_mm;
    return world_mm + (breath->WorldMm(all_mm) - breath->WorldMm(breath_mm));
  };
  const Eigen::AlignedBox3d pressed = PressedPart(breathed, reach, detail.num_threads);
  if (pressed.isEmpty()) return {};
  const double spacing_mm = std::clamp(std::cbrt(pressed.volume() / std::max(1, detail.most_knots)),
                                       kFinestMm, kCoarsestMm);
  return {pressed, spacing_mm, breathed, detail.num_threads};
}

}  // namespace acus::effects
