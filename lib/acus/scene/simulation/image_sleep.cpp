#include "acus/scene/simulation/image_sleep.h"

#include <algorithm>
#include <cstring>

#include "acus/imaging/acoustics/beam_width.h"

namespace acus::simulation {
namespace {

/// Compares bits, not values: functions may distinguish 0 and -0, and a NaN equals itself.
bool Same(const double* a, const double* b, std::size_t count) noexcept {
  return std::memcmp(a, b, count * sizeof(double)) == 0;
}

bool Same(const Eigen::Vector3d& a, const Eigen::Vector3d& b) noexcept {
  return Same(a.data(), b.data(), 3);
}

bool Same(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) noexcept {
  return Same(a.data(), b.data(), 16);
}

bool Same(const math::Polyline& a, const math::Polyline& b) noexcept {
  if (a.num_points != b.num_points) return false;
  for (int i = 0; i < a.num_points; ++i) {
    if (!Same(a.At(i), b.At(i))) return false;
  }
  return true;
}

bool Same(const tissue::TissueLoad& a, const tissue::TissueLoad& b) noexcept {
  if (a.num_points != b.num_points) return false;
  for (std::size_t i = 0; i < static_cast<std::size_t>(a.num_points); ++i) {
    if (!Same(a.point[i].rest_in_ct_mm, b.point[i].rest_in_ct_mm) ||
        !Same(a.point[i].force_in_ct_n, b.point[i].force_in_ct_n)) {
      return false;
    }
  }
  const tissue::NeedleLoad& n = a.needle;
  const tissue::NeedleLoad& m = b.needle;
  const double forces_a[] = {n.pre_puncture_n, n.cutting_n, n.friction_n};
  const double forces_b[] = {m.pre_puncture_n, m.cutting_n, m.friction_n};
  return n.in_contact == m.in_contact && n.pierced == m.pierced &&
         Same(n.entry_in_ct_mm, m.entry_in_ct_mm) && Same(n.tip_in_ct_mm, m.tip_in_ct_mm) &&
         Same(n.axis_in_ct, m.axis_in_ct) && Same(forces_a, forces_b, 3);
}

template <typename T>
bool SameOrNone(const T* a, const T* b) noexcept {
  return a == nullptr || b == nullptr ? a == b : Same(*a, *b);
}

}  // namespace

bool BreathHasStayed(const Scene& scene, const Snapshot& before, const Snapshot& now) noexcept {
  if (!scene.breathing || !scene.breathing->image) return true;
  const breathing::MotionMap at_a = scene.breathing->At(before.session_s, before.breath);
  const breathing::MotionMap at_b = scene.breathing->At(now.session_s, now.breath);
  const breathing::MotionWeights& a = at_a.weights();
  const breathing::MotionWeights& b = at_b.weights();
  const auto count = static_cast<std::size_t>(a.count);
  return a.count == b.count && std::memcmp(a.component.data(), b.component.data(), count) == 0 &&
         std::memcmp(a.weight.data(), b.weight.data(), count * sizeof(float)) == 0;
}

bool TissueHasStayed(const Scene& scene, const Snapshot& before, const Snapshot& now) noexcept {
  if (scene.tools_deform_images && !SameOrNone(before.load, now.load)) return false;
  return BreathHasStayed(scene, before, now) &&
         scene.listed.IsSameMotion(before.memory, now.memory);
}

bool NeedleHasStayed(const Snapshot& before, const Snapshot& now) noexcept {
  if (before.ct_from_needle.has_value() != now.ct_from_needle.has_value()) return false;
  if (!now.ct_from_needle) return true;
  return Same(*before.ct_from_needle, *now.ct_from_needle) &&
         SameOrNone(before.needle_shape, now.needle_shape);
}

bool ProbeHasStayed(const Snapshot& before, const Snapshot& now) noexcept {
  return before.probe_valid == now.probe_valid &&
         (!now.probe_valid || Same(before.ct_from_probe, now.ct_from_probe));
}

double NeedleReachMm(const acoustics::Probe& probe, double needle_radius_mm) {
  // Painted needles show within half the slice thickness, those by beams within 1.5 thicknesses.
  double thickest_mm = probe.slice_thickness_mm;
  constexpr int kDepths = 512;
  for (int i = 0; i <= kDepths; ++i) {
    thickest_mm =
        std::max(thickest_mm, acoustics::ElevationFwhmMm(probe, probe.depth_mm * i / kDepths));
  }
  return 1.6 * thickest_mm + needle_radius_mm + 0.1;
}

bool NeedleIsOffPlane(const Scene& scene, const Snapshot& snapshot, double reach_mm) noexcept {
  if (!snapshot.ct_from_needle) return true;
  const Eigen::Vector3d normal = snapshot.ct_from_probe.linear().col(2);
  bool all_before = true;
  bool all_behind = true;
  // A position that is not finite is on neither side: the renderer reports it.
  const auto add = [&](const Eigen::Vector3d& place_in_ct_mm) {
    const double z_mm = normal.dot(place_in_ct_mm - snapshot.ct_from_probe.translation());
    all_before &= z_mm > reach_mm;
    all_behind &= z_mm < -reach_mm;
  };
  const math::Polyline* shape = snapshot.needle_shape;
  if (shape != nullptr && shape->num_points >= 2) {
    for (int i = 0; i < shape->num_points; ++i) add(shape->At(i));
  } else {
    const Eigen::Isometry3d& needle = *snapshot.ct_from_needle;
    add(needle.translation());
    add(needle * Eigen::Vector3d(0.0, 0.0, -scene.needle->length_mm));
  }
  return all_before || all_behind;
}

}  // namespace acus::simulation
