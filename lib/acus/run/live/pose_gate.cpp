#include "acus/run/live/pose_gate.h"

#include <algorithm>
#include <cmath>

#include "acus/data/session/pose_csv.h"

namespace acus::live {
namespace {

constexpr double kLongestPoseStepS = 0.1;

bool IsUsable(const transforms::Pose& pose) noexcept {
  const Eigen::Vector4d& q = pose.quaternion().coeffs();
  return pose.matrix().allFinite() && q.allFinite() && std::abs(q.norm() - 1.0) < 1e-6 &&
         pose.translation().cwiseAbs().maxCoeff() <= session::kMaxCoordinateMm;
}

}  // namespace

bool PoseGate::IsNear(const transforms::Pose& before, std::int64_t before_ns,
                      const transforms::Pose& pose, std::int64_t time_ns) const noexcept {
  const double dt_s =
      std::clamp(1e-9 * static_cast<double>(time_ns - before_ns), 0.0, kLongestPoseStepS);
  const double moved_mm = (pose.translation() - before.translation()).norm();
  const double cosine = std::abs(pose.quaternion().dot(before.quaternion()));
  const double turned_rad = 2.0 * std::acos(std::min(1.0, cosine));
  return moved_mm <= settings_.jump_mm + settings_.speed_mm_s * dt_s &&
         turned_rad <= settings_.jump_rad + settings_.speed_rad_s * dt_s;
}

PoseVerdict PoseGate::Judge(std::int64_t time_ns, const transforms::Pose& pose,
                            bool seen) noexcept {
  if (!seen) return PoseVerdict::kNotSeen;
  if (!IsUsable(pose)) return PoseVerdict::kNotFinite;
  bool good = !has_good_ || IsNear(last_good_, good_ns_, pose, time_ns);
  if (!good) {
    if (!has_new_place_ || !IsNear(new_place_, new_ns_, pose, time_ns)) new_since_ns_ = time_ns;
    has_new_place_ = true;
    new_place_ = pose;
    new_ns_ = time_ns;
    good = 1e-9 * static_cast<double>(time_ns - new_since_ns_) >= settings_.settle_s;
  }
  if (!good) return PoseVerdict::kJumped;
  has_good_ = true;
  has_new_place_ = false;
  last_good_ = pose;
  good_ns_ = time_ns;
  return PoseVerdict::kGood;
}

}  // namespace acus::live
