// The devices file as a live session reads it: haptic devices, trackers, and where they stand.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "acus/rig/camera/camera_tracker.h"
#include "acus/rig/haptics/devices_file.h"
#include "acus/rig/tracking/igtl_source.h"

namespace acus::live {

/// A tracked marker or belt that follows the patient's breath.
struct BeltConfig {
  std::string tool;                                 ///< Of one of the trackers.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< Unit length, in the tracker's frame.
  double expiration_mm = 0.0;
  double inspiration_mm = 10.0;
};

/// Where poses and images are sent, for 3D Slicer and others to watch.
struct SendOut {
  std::string host = "localhost";
  int port = 18945;
};

/// A second computer that makes the images: acus-live --make-images.
struct ImagesFrom {
  std::string host = "localhost";
  int port = 18946;
};

struct TrackerConfig {
  tracking::IgtlOptions options;
  double stale_s = 0.2;  ///< News older than this: the tool is not seen.
};

/// A camera whose video is shown, and which may track tools.
struct CameraConfig {
  std::filesystem::path model;
  std::filesystem::path facets;
  camera::CameraTrackerOptions options;
  double stale_s = 0.2;
};

struct LiveDevices {
  std::string name;
  haptics::DevicesFile haptics;
  /// By haptic device. mm.
  std::map<std::string, Eigen::Isometry3d> reference_from_device;
  std::vector<TrackerConfig> trackers;
  std::optional<CameraConfig> camera;
  std::optional<BeltConfig> belt;
  std::optional<SendOut> send_out;
  std::optional<ImagesFrom> images_from;

  /// The tracker with the tool of that name (the camera comes after the others), and its number
  /// there.
  struct Place {
    std::size_t tracker = 0;
    std::size_t tool = 0;
    double stale_s = 0.0;
  };
  std::optional<Place> FindTracked(const std::string& tool) const;

  bool has_needle() const { return !haptics.needle.device.empty() || FindTracked("needle"); }
  bool has_probe() const { return !haptics.probe.device.empty() || FindTracked("probe"); }
};

/// @throws InputError: what the schema and haptics::ReadDevices() say; a tool that is on a device
///     and tracked as well, or tracked twice; a transform file that is not readable; nothing that
///     holds needle or probe.
LiveDevices ReadLiveDevices(const std::filesystem::path& path);

}  // namespace acus::live
