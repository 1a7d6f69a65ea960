#include "acus/run/training/situation.h"

#include <cmath>

namespace acus::training {

bool ImageField::Contains(double x_mm, double y_mm) const {
  if (half_angle_rad > 0.0) {
    const double from_centre_mm = std::hypot(x_mm, y_mm + radius_mm);
    const double angle_rad = std::atan2(std::abs(x_mm), y_mm + radius_mm);
    return angle_rad <= half_angle_rad && from_centre_mm >= radius_mm &&
           from_centre_mm - radius_mm <= depth_mm;
  }
  return std::abs(x_mm) <= half_width_mm && y_mm >= 0.0 && y_mm <= depth_mm;
}

Situation SituationOf(const session::PoseSample& needle, const session::PoseSample* probe,
                      const ImageField& field, const LabelAtPoint& label_at,
                      const SituationOptions& options) {
  Situation now;
  now.needle_seen = needle.valid;
  now.probe_seen = probe != nullptr && probe->valid;
  const Eigen::Vector3d tip_mm = needle.reference_from_tool.translation();
  if (now.needle_seen) {
    now.tip_mm = tip_mm;
    now.needle_in_tissue = label_at(tip_mm) != 0;
    const Eigen::Vector3d ahead_mm =
        tip_mm + options.contact_mm * needle.reference_from_tool.linear().col(2);
    now.needle_at_skin = !now.needle_in_tissue && label_at(ahead_mm) != 0;
    if (options.target_mm) {
      now.tip_to_target_mm = (tip_mm - *options.target_mm).norm();
      now.target_reached = *now.tip_to_target_mm <= options.target_radius_mm;
    }
  }
  if (!now.probe_seen) return now;
  const transforms::Pose& pose = probe->reference_from_tool;
  const auto in_probe = [&](const Eigen::Vector3d& point_mm) -> Eigen::Vector3d {
    return pose.linear().transpose() * (point_mm - pose.translation());
  };
  now.probe_on_skin = label_at(pose.translation() + options.contact_mm * pose.linear().col(1)) != 0;
  if (options.target_mm) {
    const Eigen::Vector3d at_mm = in_probe(*options.target_mm);
    now.target_in_probe_mm = at_mm;
    now.target_in_view = std::abs(at_mm.z()) <= options.plane.half_thickness_mm &&
                         field.Contains(at_mm.x(), at_mm.y());
  }
  if (!now.needle_seen) return now;
  now.tip_in_probe_mm = in_probe(tip_mm);
  const Eigen::Vector3d shaft_mm =
      tip_mm - options.plane.shaft_mm * needle.reference_from_tool.linear().col(2);
  now.needle_in_plane =
      IsInPlane(tip_mm, pose, options.plane) && IsInPlane(shaft_mm, pose, options.plane);
  return now;
}

std::optional<double> GapToSkinMm(const transforms::Pose& reference_from_probe,
                                  const LabelAtPoint& label_at, double reach_mm) {
  const Eigen::Vector3d face_mm = reference_from_probe.translation();
  const Eigen::Vector3d beam = reference_from_probe.linear().col(1);
  for (double gap_mm = 0.0; gap_mm <= reach_mm; gap_mm += 1.0) {
    if (label_at(face_mm + gap_mm * beam) != 0) return gap_mm;
  }
  return std::nullopt;
}

double DepthBelowSkinMm(const transforms::Pose& reference_from_probe, const LabelAtPoint& label_at,
                        double reach_mm) {
  const Eigen::Vector3d face_mm = reference_from_probe.translation();
  const Eigen::Vector3d beam = reference_from_probe.linear().col(1);
  double depth_mm = 0.0;
  while (depth_mm < reach_mm && label_at(face_mm - depth_mm * beam) != 0) depth_mm += 1.0;
  return depth_mm;
}

}  // namespace acus::training
