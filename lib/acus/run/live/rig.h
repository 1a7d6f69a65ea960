// The devices and trackers of a workplace, which may stay open from one session to the next.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "acus/rig/camera/camera_tracker.h"
#include "acus/rig/haptics/haptic_device.h"
#include "acus/rig/tracking/pose_source.h"
#include "acus/run/live/live_devices.h"

namespace acus::live {

class Rig {
 public:
  enum class Use {
    kCheck,         ///< No vendor's library is loaded, no device searched for.
    kOneSession,    ///< Devices and trackers stop with the session.
    kManySessions,  ///< Between sessions devices are parked, and trackers run.
  };

  /// Starts the trackers and opens the devices that hands hold, motors off. Virtual hands belong to
  /// their session, as their path does.
  /// @throws InputError with a message for the user.
  Rig(const LiveDevices& devices, Use use);
  ~Rig();  ///< Stops all.
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  const LiveDevices& devices() const { return devices_; }
  /// The device of that name; null if it is a virtual hand, or has no tool.
  haptics::HapticDevice* Find(const std::string& device) const;
  /// In the order of LiveDevices::FindTracked(): the camera is the last.
  const std::vector<std::unique_ptr<tracking::PoseSource>>& trackers() const { return trackers_; }
  /// The camera whose video is shown; null if there is none.
  const camera::CameraTracker* camera() const { return camera_; }

  /// Starts the trackers that do not run yet.
  void StartTrackers();
  /// At the end of a session, zero force first: parks or stops the devices, depending on `use`.
  void ReleaseDevices() noexcept;
  void ReleaseTrackers() noexcept;

 private:
  struct Device {
    std::string name;
    std::unique_ptr<haptics::HapticDevice> device;
  };

  LiveDevices devices_;
  Use use_;
  bool trackers_run_ = false;
  std::vector<std::unique_ptr<tracking::PoseSource>> trackers_;
  const camera::CameraTracker* camera_ = nullptr;
  std::vector<Device> opened_;
};

}  // namespace acus::live
