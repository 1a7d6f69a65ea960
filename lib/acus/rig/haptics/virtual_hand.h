// A hand that is not there: holds the handle of a device without motors, wants to go somewhere,
// trembles, and yields to forces. docs/concepts/haptic_devices.md.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <mutex>
#include <vector>

#include "acus/base/core/seqlock.h"
#include "acus/base/math/driven_mass.h"
#include "acus/rig/haptics/device_reading.h"

namespace acus::haptics {

/// Where a hand wants to be at a time.
struct GoalPoint {
  double time_s = 0.0;
  Eigen::Isometry3d device_from_handle = Eigen::Isometry3d::Identity();  ///< mm.
};

struct GoalPath {
  enum class Between {
    kMinimumJerk,  ///< Waypoints: rests at each.
    kLinear,       ///< A recording.
  };
  std::vector<GoalPoint> points;  ///< Times increase.
  Between between = Between::kMinimumJerk;
  bool repeats = false;  ///< From the last point on to the first, again and again.

  /// The first point before its time; the last one after it, unless it repeats. Identity if there
  /// is no point. Never allocates.
  Eigen::Isometry3d At(double time_s) const noexcept;
  /// @throws InputError if times do not increase or a pose is not rigid.
  void Check() const;
};

struct VirtualHandSettings {
  double mass_kg = 0.15;  ///< Of handle, arm of the device, and what of the hand moves with it.
  double damping_n_s_per_m = 0.5;
  double stiffness_n_per_m = 400.0;  ///< Of the grip; forces::Hand.
  double grip_damping_n_s_per_m = 15.0;
  double inertia_kg_mm2 = 100.0;
  double grip_torque_nmm_per_rad = 2000.0;
  /// A hand that watches its tool moves its goal by what a force pushes it off, with this time
  /// constant; 0: it yields and stays off. Not while it is steered by a person.
  double correction_s = 0.0;
  double tremor_mm = 0.1;     ///< Amplitude along each axis, at about 9 Hz.
  double encoder_mm = 0.02;   ///< Steps of the reading; 0: exact.
  double max_force_n = 20.0;  ///< Of the motors that it pretends to have.
  double max_torque_nmm = 1000.0;
  double rate_hz = 1000.0;
  GoalPath path;

  void Check() const;  ///< @throws InputError
};

/// Steers a virtual hand from another thread: by mouse and keyboard, or by a test. The hand follows
/// its path until it is steered. Any number of threads; the hand itself never waits for them.
class HandSteering {
 public:
  /// The hand wants to be there from now on.
  void SetGoal(const Eigen::Isometry3d& device_from_handle);
  /// Moves the goal, from where it is now, by `way_mm` in the device frame, and turns it about the
  /// handle's origin by the rotation vector `turn_rad`, device frame.
  void Nudge(const Eigen::Vector3d& way_mm, const Eigen::Vector3d& turn_rad);
  /// Back to the path, which has gone on meanwhile.
  void FollowPath();
  void SetButtons(unsigned buttons);
  /// What the hand wants at present. Before its first step: identity.
  Eigen::Isometry3d goal() const;
  bool is_steered() const;

 private:
  friend class VirtualHand;
  struct Wish {
    std::array<double, 7> goal;  ///< x y z qw qx qy qz.
    unsigned buttons;
    unsigned is_steered;
  };

  mutable std::mutex mutex_;  ///< Of those who steer.
  Wish wish_{};
  Seqlock<Wish> published_;
  Seqlock<std::array<double, 7>> present_goal_;  ///< Written by the hand.
};

/// The model. Deterministic: the same times and forces give the same bits.
class VirtualHand {
 public:
  /// @pre settings.Check() passes. `steering` may be null, and must outlive the hand.
  VirtualHand(VirtualHandSettings settings, HandSteering* steering);

  /// Moves on by `dt_s` (0 to 0.1) under `force`, and reads. Never allocates or waits.
  DeviceReading Step(const DeviceForce& force, double dt_s) noexcept;

  const VirtualHandSettings& settings() const { return settings_; }

 private:
  void AskSteering() noexcept;
  Eigen::Vector3d Tremor() const noexcept;
  void Correct(double dt_s) noexcept;
  void Turn(const Eigen::Vector3d& torque_nmm, double dt_s) noexcept;

  VirtualHandSettings settings_;
  HandSteering* steering_;
  HandSteering::Wish wish_{};
  math::DrivenMass mass_;
  math::DrivenMass::State state_;
  Eigen::Quaterniond rotation_ = Eigen::Quaterniond::Identity();
  Eigen::Vector3d spin_rad_s_ = Eigen::Vector3d::Zero();
  Eigen::Isometry3d goal_ = Eigen::Isometry3d::Identity();
  Eigen::Vector3d correction_mm_ = Eigen::Vector3d::Zero();
  double time_s_ = 0.0;
};

}  // namespace acus::haptics
