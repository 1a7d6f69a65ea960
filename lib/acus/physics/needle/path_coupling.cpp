#include "acus/physics/needle/path_coupling.h"

#include <algorithm>
#include <cmath>

namespace acus::needle {

using Eigen::Quaterniond;
using Eigen::Vector3d;

int CoupleToPath(const RodModel& rod, const CurvedPath& path, const CouplingOptions& options,
                 std::span<RodContact> contacts) noexcept {
  if (path.empty()) return 0;
  const double length_mm = rod.properties().length_mm;
  const double depth_mm = path.LengthMm();
  const double skin_arc_mm = length_mm - depth_mm;
  const int capacity = static_cast<int>(contacts.size());
  int count = 0;
  const auto put = [&](double arc_mm, double stiffness_n_per_mm, bool across) {
    if (count == capacity || stiffness_n_per_mm <= 0.0) return;
    const double at_mm = arc_mm - skin_arc_mm;
    RodContact& contact = contacts[count++];
    contact.arc_mm = arc_mm;
    contact.anchor_mm = path.PositionMm(at_mm);
    contact.free_axis = across ? path.Direction(at_mm, Vector3d::Zero()) : Vector3d::Zero();
    contact.stiffness_n_per_mm = stiffness_n_per_mm;
  };
  put(length_mm, options.tip_stiffness_n_per_mm, false);
  // A needle longer in the body than it is has its hub at the skin.
  if (skin_arc_mm >= 0.0) put(skin_arc_mm, options.entry_stiffness_n_per_mm, true);
  const double h = rod.spacing_mm();
  const int first = std::clamp(static_cast<int>(skin_arc_mm / h), 0, rod.num_elements());
  for (int i = first; i < rod.num_elements(); ++i) {
    const double begin_mm = std::max(i * h, skin_arc_mm);
    const double buried_mm = (i + 1) * h - begin_mm;
    if (buried_mm <= 0.0) continue;
    const double middle_mm = begin_mm + 0.5 * buried_mm;
    const double support = path.SupportNPerMm(begin_mm + buried_mm - skin_arc_mm) -
                           path.SupportNPerMm(begin_mm - skin_arc_mm);
    put(middle_mm, support, true);
  }
  return count;
}

void MoveContacts(const PathMotion& motion, std::span<RodContact> contacts) noexcept {
  for (RodContact& contact : contacts) {
    const Vector3d rest_mm = contact.anchor_mm;
    contact.anchor_mm = motion.NowMm(rest_mm);
    if (contact.free_axis.isZero(0.0)) continue;
    contact.free_axis = motion.NowMm(rest_mm + contact.free_axis) - contact.anchor_mm;
  }
}

RodBase BaseFromHand(const Vector3d& insertion_mm, double length_outside_mm,
                     const Quaterniond& hand, const HandSpring& spring) noexcept {
  RodBase base;
  base.position_mm = insertion_mm - length_outside_mm * (hand * Vector3d::UnitZ());
  base.orientation = hand;
  base.sprung = true;
  base.stiffness_n_per_mm = spring.stiffness_n_per_mm;
  base.stiffness_n_mm_per_rad = spring.stiffness_n_mm_per_rad;
  return base;
}

Vector3d HandForceN(double kappa_n_per_mm, const Vector3d& hub_mm, const Vector3d& hand_mm,
                    const Vector3d& path_direction) noexcept {
  const Vector3d off_mm = hub_mm - hand_mm;
  return kappa_n_per_mm * (off_mm - off_mm.dot(path_direction) * path_direction);
}

Vector3d HandTorqueNMm(double stiffness_n_mm_per_rad, const Quaterniond& hand,
                       const Vector3d& tangent_at_skin) noexcept {
  const Vector3d axis = hand * Vector3d::UnitZ();
  const Vector3d cross = axis.cross(tangent_at_skin);
  const double sine = cross.norm();
  if (!(sine > 1e-12)) return Vector3d::Zero();
  const double angle_rad = std::atan2(sine, axis.dot(tangent_at_skin));
  return stiffness_n_mm_per_rad * angle_rad / sine * cross;
}

}  // namespace acus::needle
