#include "acus/run/training/plane_share.h"

#include <cmath>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::training {

PlaneShare ComputePlaneShare(const session::Session& session, const InsideTissue& inside,
                             const PlaneOptions& options) {
  ACUS_REQUIRE(options.half_thickness_mm > 0.0 && std::isfinite(options.half_thickness_mm),
               "half_thickness_mm is ", options.half_thickness_mm, "; it must be positive");
  ACUS_REQUIRE(options.shaft_mm > 0.0 && std::isfinite(options.shaft_mm), "shaft_mm is ",
               options.shaft_mm, "; it must be positive");
  PlaneShare share;
  if (session.probe.empty()) return share;
  double tip_s = 0.0;
  double needle_s = 0.0;
  const session::PoseSample* last = nullptr;
  for (const session::PoseSample& sample : session.needle) {
    if (!sample.valid) {
      last = nullptr;  // The time until it is seen again is not counted.
      continue;
    }
    const session::PoseSample* before = std::exchange(last, &sample);
    if (before == nullptr) continue;
    const Eigen::Vector3d tip_mm = sample.reference_from_tool.translation();
    const session::PoseSample probe = session::PoseAt(session.probe, sample.time_ns);
    if (!probe.valid || !inside(tip_mm)) continue;
    const double step_s = 1e-9 * static_cast<double>(sample.time_ns - before->time_ns);
    const auto in_plane = [&](const Eigen::Vector3d& point_mm) {
      const Eigen::Vector3d normal = probe.reference_from_tool.linear().col(2);
      return std::abs(normal.dot(point_mm - probe.reference_from_tool.translation())) <=
             options.half_thickness_mm;
    };
    share.seconds += step_s;
    if (!in_plane(tip_mm)) continue;
    tip_s += step_s;
    if (in_plane(tip_mm - options.shaft_mm * sample.reference_from_tool.linear().col(2))) {
      needle_s += step_s;
    }
  }
  if (share.seconds > 0.0) {
    share.tip_percent = 100.0 * tip_s / share.seconds;
    share.needle_percent = 100.0 * needle_s / share.seconds;
  }
  return share;
}

}  // namespace acus::training
