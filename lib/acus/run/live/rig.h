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
    kCheck,         ///< No vendor's library is loaded, no device looked for.
    kOneSession,    ///< Devices and trackers stop with the session.
    kManySessions,  ///< Between sessions devices are parked, and trackers run.
  };

  /// Makes the trackers and opens the devices that hands hold, motors off. Virtual hands belong to
  /// their session, as their path does.
  /// @throws InputError in plain words.
  Rig(const LiveDevices& devices, Use use);
  ~Rig();  ///< Stops all.
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  const LiveDevices& devices() const { return devices_; }
  /// The device of that name; null if it is a virtual hand, or no tool is on it.
  haptics::HapticDevice* Find(const std::string& device) const;
  /// As LiveDevices::FindTracked() numbers them: the camera is the last.
  const std::vector<std::unique_ptr<tracking::PoseSource>>& trackers() const { return trackers_; }
  /// The camera whose video is shown; null if there is none.
  const camera::CameraTracker* camera() const { return camera_; }

  /// Those that run already run on.
  void StartTrackers();
  /// The end of a session, zero force first: parks or stops the devices, as `use` says.
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
