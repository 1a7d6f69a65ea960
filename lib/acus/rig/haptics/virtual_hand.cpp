#include "acus/rig/haptics/virtual_hand.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"

namespace acus::haptics {
namespace {

constexpr int kSubsteps = 10;
constexpr double kTremorHz = 9.0;
constexpr double kFurthestCorrectionMm = 20.0;
constexpr double kStrongestPullN = 60.0;  ///< No hand pulls harder, however far its goal is.

std::array<double, 7> Pack(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  const Eigen::Vector3d t = pose.translation();
  return {t.x(), t.y(), t.z(), q.w(), q.x(), q.y(), q.z()};
}

Eigen::Isometry3d Unpack(const std::array<double, 7>& p) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  const Eigen::Quaterniond q(p[3], p[4], p[5], p[6]);
  if (q.squaredNorm() > 0.5) pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(p[0], p[1], p[2]);
  return pose;
}

/// From 0 to 1 with no speed and no acceleration at both ends.
double MinimumJerk(double s) {
  return s * s * s * (10.0 + s * (-15.0 + 6.0 * s));
}

Eigen::Vector3d RotationVector(const Eigen::Quaterniond& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  const double angle = std::remainder(turn.angle(), 2.0 * std::numbers::pi);
  return angle * turn.axis();
}

Eigen::Quaterniond FromRotationVector(const Eigen::Vector3d& turn_rad) {
  const double angle = turn_rad.norm();
  if (angle <= 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn_rad / angle));
}

void RequireWithin(const char* key, double value, double low, double high) {
  ACUS_REQUIRE(value >= low && value <= high, "virtual hand: ", key, " is ", value,
               "; it must lie in [", low, ", ", high, "]");
}

}  // namespace

Eigen::Isometry3d GoalPath::At(double time_s) const noexcept {
  if (points.empty()) return Eigen::Isometry3d::Identity();
  const double begin_s = points.front().time_s;
  const double length_s = points.back().time_s - begin_s;
  if (repeats && length_s > 0.0 && time_s > begin_s) {
    time_s = begin_s + std::fmod(time_s - begin_s, length_s);
  }
  const auto after =
      std::upper_bound(points.begin(), points.end(), time_s,
                       [](double value, const GoalPoint& p) { return value < p.time_s; });
  if (after == points.begin()) return points.front().device_from_handle;
  if (after == points.end()) return points.back().device_from_handle;
  const GoalPoint& from = *(after - 1);
  const double share = (time_s - from.time_s) / (after->time_s - from.time_s);
  return math::Interpolate(from.device_from_handle, after->device_from_handle,
                           between == Between::kLinear ? share : MinimumJerk(share));
}

void GoalPath::Check() const {
  for (std::size_t i = 0; i < points.size(); ++i) {
    ACUS_REQUIRE(
        std::isfinite(points[i].time_s) && (i == 0 || points[i].time_s > points[i - 1].time_s),
        "virtual hand: the time of point ", i, " of its path is ", points[i].time_s,
        " s; times must increase");
    ACUS_REQUIRE(math::IsRigid(points[i].device_from_handle.matrix()), "virtual hand: point ", i,
                 " of its path is no pose");
  }
}

void VirtualHandSettings::Check() const {
  RequireWithin("mass_kg", mass_kg, 0.01, 10.0);
  RequireWithin("damping_n_s_per_m", damping_n_s_per_m, 0.0, 1000.0);
  RequireWithin("stiffness_n_per_m", stiffness_n_per_m, 1.0, 5000.0);
  RequireWithin("grip_damping_n_s_per_m", grip_damping_n_s_per_m, 0.0, 1000.0);
  RequireWithin("inertia_kg_mm2", inertia_kg_mm2, 1.0, 1e5);
  RequireWithin("grip_torque_nmm_per_rad", grip_torque_nmm_per_rad, 1.0, 1e5);
  RequireWithin("correction_s", correction_s, 0.0, 10.0);
  RequireWithin("tremor_mm", tremor_mm, 0.0, 5.0);
  RequireWithin("encoder_mm", encoder_mm, 0.0, 1.0);
  RequireWithin("max_force_n", max_force_n, 0.0, 40.0);
  RequireWithin("max_torque_nmm", max_torque_nmm, 0.0, 5000.0);
  RequireWithin("rate_hz", rate_hz, 100.0, 4000.0);
  path.Check();
}

void HandSteering::SetGoal(const Eigen::Isometry3d& device_from_handle) {
  if (!device_from_handle.matrix().allFinite()) return;
  const std::lock_guard lock(mutex_);
  wish_.goal = Pack(device_from_handle);
  wish_.is_steered = 1;
  published_.Store(wish_);
}

void HandSteering::Nudge(const Eigen::Vector3d& way_mm, const Eigen::Vector3d& turn_rad) {
  if (!way_mm.allFinite() || !turn_rad.allFinite()) return;
  const std::lock_guard lock(mutex_);
  // Several nudges may come between two steps of the hand.
  const Eigen::Isometry3d from = Unpack(wish_.is_steered != 0 ? wish_.goal : present_goal_.Load());
  Eigen::Isometry3d to = Eigen::Isometry3d::Identity();
  to.linear() = FromRotationVector(turn_rad).toRotationMatrix() * from.linear();
  to.translation() = from.translation() + way_mm;
  wish_.goal = Pack(to);
  wish_.is_steered = 1;
  published_.Store(wish_);
}

void HandSteering::FollowPath() {
  const std::lock_guard lock(mutex_);
  wish_.is_steered = 0;
  published_.Store(wish_);
}

void HandSteering::SetButtons(unsigned buttons) {
  const std::lock_guard lock(mutex_);
  wish_.buttons = buttons;
  published_.Store(wish_);
}

Eigen::Isometry3d HandSteering::goal() const {
  return Unpack(present_goal_.Load());
}

bool HandSteering::is_steered() const {
  const std::lock_guard lock(mutex_);
  return wish_.is_steered != 0;
}

VirtualHand::VirtualHand(VirtualHandSettings settings, HandSteering* steering)
    : settings_(std::move(settings)), steering_(steering) {
  mass_ = {.mass_kg = settings_.mass_kg,
           .damping_n_s_per_mm = settings_.damping_n_s_per_m * 1e-3,
           .hand_n_per_mm = settings_.stiffness_n_per_m * 1e-3,
           .hand_n_s_per_mm = settings_.grip_damping_n_s_per_m * 1e-3,
           .dry_friction_n = 0.0};
  goal_ = settings_.path.At(0.0);
  AskSteering();
  state_.place_mm = goal_.translation();
  state_.wanted_mm = goal_.translation() + Tremor();
  rotation_ = Eigen::Quaterniond(goal_.linear());
}

void VirtualHand::AskSteering() noexcept {
  if (steering_ == nullptr) return;
  steering_->published_.TryLoad(wish_);  // Or the wish of the last step.
  if (wish_.is_steered != 0) goal_ = Unpack(wish_.goal);
  steering_->present_goal_.Store(Pack(goal_));
}

Eigen::Vector3d VirtualHand::Tremor() const noexcept {
  // Three frequencies that never meet, so that the tremor has no direction.
  const double phase = 2.0 * std::numbers::pi * kTremorHz * time_s_;
  return settings_.tremor_mm * Eigen::Vector3d(std::sin(1.13 * phase + 1.0), std::sin(phase),
                                               std::sin(0.91 * phase + 2.0));
}

void VirtualHand::Correct(double dt_s) noexcept {
  if (settings_.correction_s <= 0.0 || wish_.is_steered != 0) {
    correction_mm_.setZero();
    return;
  }
  correction_mm_ += dt_s / settings_.correction_s * (goal_.translation() - state_.place_mm);
  if (correction_mm_.norm() > kFurthestCorrectionMm) {
    correction_mm_ *= kFurthestCorrectionMm / correction_mm_.norm();
  }
}

void VirtualHand::Turn(const Eigen::Vector3d& torque_nmm, double dt_s) noexcept {
  const double inertia = settings_.inertia_kg_mm2 * 1e-3;  // N mm s^2.
  const double spring = settings_.grip_torque_nmm_per_rad;
  const double damper = 2.0 * std::sqrt(spring * inertia);  // Critical: no hand oscillates.
  const Eigen::Vector3d away_rad =
      RotationVector(Eigen::Quaterniond(goal_.linear()) * rotation_.conjugate());
  spin_rad_s_ = (spin_rad_s_ + dt_s / inertia * (torque_nmm + spring * away_rad)) /
                (1.0 + dt_s / inertia * damper);
  rotation_ = (FromRotationVector(dt_s * spin_rad_s_) * rotation_).normalized();
}

DeviceReading VirtualHand::Step(const DeviceForce& force, double dt_s) noexcept {
  dt_s = std::clamp(dt_s, 0.0, 0.1);
  const double step_s = dt_s / kSubsteps;
  for (int i = 0; i < kSubsteps && step_s > 0.0; ++i) {
    time_s_ += step_s;
    goal_ = settings_.path.At(time_s_);
    if (wish_.is_steered != 0) goal_ = Unpack(wish_.goal);
    // A goal that was set far away is approached as fast as a hand can pull.
    Correct(step_s);
    const Eigen::Vector3d wanted_mm = goal_.translation() + correction_mm_ + Tremor();
    Eigen::Vector3d way_mm = wanted_mm - state_.place_mm;
    const double furthest_mm = kStrongestPullN / mass_.hand_n_per_mm;
    if (way_mm.norm() > furthest_mm) way_mm *= furthest_mm / way_mm.norm();
    const Eigen::Vector3d reached_mm = state_.place_mm + way_mm;
    // The damper follows a moving goal, not one that was set elsewhere.
    if ((reached_mm - state_.wanted_mm).norm() > 1000.0 * step_s) state_.wanted_mm = reached_mm;
    mass_.Step(state_, reached_mm, force.force_n, step_s);
    Turn(force.torque_nmm, step_s);
  }
  AskSteering();

  DeviceReading reading;
  reading.device_from_handle.linear() = rotation_.toRotationMatrix();
  reading.device_from_handle.translation() =
      settings_.encoder_mm > 0.0
          ? Eigen::Vector3d((state_.place_mm / settings_.encoder_mm).array().round().matrix() *
                            settings_.encoder_mm)
          : state_.place_mm;
  reading.velocity_mm_s = state_.velocity_mm_s;
  reading.angular_velocity_rad_s = spin_rad_s_;
  reading.buttons = wish_.buttons;
  reading.valid = true;
  return reading;
}

}  // namespace acus::haptics
