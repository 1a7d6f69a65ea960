#include "acus/run/training/plane_share.h"

#include <cmath>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::training {

bool IsInPlane(const Eigen::Vector3d& point_mm, const transforms::Pose& reference_from_probe,
               const PlaneOptions& options) {
  const Eigen::Vector3d normal = reference_from_probe.linear().col(2);
  return std::abs(normal.dot(point_mm - reference_from_probe.translation())) <=
         options.half_thickness_mm;
}

PlaneMeter::PlaneMeter(InsideTissue inside, const PlaneOptions& options)
    : inside_(std::move(inside)), options_(options) {
  ACUS_REQUIRE(options.half_thickness_mm > 0.0 && std::isfinite(options.half_thickness_mm),
               "half_thickness_mm is ", options.half_thickness_mm, "; it must be positive");
  ACUS_REQUIRE(options.shaft_mm > 0.0 && std::isfinite(options.shaft_mm), "shaft_mm is ",
               options.shaft_mm, "; it must be positive");
}

void PlaneMeter::Add(const session::PoseSample& needle, const session::PoseSample& probe) {
  if (!needle.valid) {
    last_ns_.reset();  // The time until the tool is seen again is not counted.
    return;
  }
  const auto before_ns = std::exchange(last_ns_, needle.time_ns);
  if (!before_ns) return;
  const Eigen::Vector3d tip_mm = needle.reference_from_tool.translation();
  if (!probe.valid || !inside_(tip_mm)) return;
  const double step_s = 1e-9 * static_cast<double>(needle.time_ns - *before_ns);
  seconds_ += step_s;
  if (!IsInPlane(tip_mm, probe.reference_from_tool, options_)) return;
  tip_s_ += step_s;
  const Eigen::Vector3d shaft_mm =
      tip_mm - options_.shaft_mm * needle.reference_from_tool.linear().col(2);
  if (IsInPlane(shaft_mm, probe.reference_from_tool, options_)) needle_s_ += step_s;
}

PlaneShare PlaneMeter::share() const {
  PlaneShare share{.seconds = seconds_};
  if (seconds_ > 0.0) {
    share.tip_percent = 100.0 * tip_s_ / seconds_;
    share.needle_percent = 100.0 * needle_s_ / seconds_;
  }
  return share;
}

PlaneShare ComputePlaneShare(const session::Session& session, const InsideTissue& inside,
                             const PlaneOptions& options) {
  PlaneMeter meter(inside, options);
  if (session.probe.empty()) return meter.share();
  for (const session::PoseSample& sample : session.needle) {
    meter.Add(sample, session::PoseAt(session.probe, sample.time_ns));
  }
  return meter.share();
}

}  // namespace acus::training
