// What a haptic device reports and receives, in the one frame that all devices are turned into.
//
// Device frame: origin where the device has its own, x to the right of the user, y up, z towards
// the user; mm, N, N mm, rad. docs/concepts/haptic_devices.md.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

namespace acus::haptics {

struct DeviceReading {
  std::int64_t time_ns = 0;  ///< CLOCK_MONOTONIC (core/monotonic_time.h) when it was read.
  Eigen::Isometry3d device_from_handle = Eigen::Isometry3d::Identity();  ///< mm.
  Eigen::Vector3d velocity_mm_s = Eigen::Vector3d::Zero();               ///< Device frame.
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();      ///< Device frame.
  unsigned buttons = 0;  ///< Bit i: button i is held.
  bool motors_on =
      true;            ///< False: the device itself holds them off (emergency stop, its dead-man).
  bool valid = false;  ///< To a servo: false means that the pose is the last good one.
};

/// On the handle, device frame.
struct DeviceForce {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque_nmm = Eigen::Vector3d::Zero();
};

/// What is called at each tick, in the device's own servo thread: it must not wait, allocate or
/// throw. Its readings are always finite and rigid; what is not valid repeats the last good pose.
struct Servo {
  DeviceForce (*tick)(void* context, const DeviceReading& reading) noexcept = nullptr;
  void* context = nullptr;
};

}  // namespace acus::haptics
