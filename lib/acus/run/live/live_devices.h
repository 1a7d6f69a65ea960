// The devices file of a live session: haptic devices, trackers, and their poses.
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
  std::string tool;                                 ///< A tool of one of the trackers.
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< Unit length, in the tracker's frame.
  double expiration_mm = 0.0;
  double inspiration_mm = 10.0;
};

/// The address to which poses and images are sent, for 3D Slicer and others.
struct SendOut {
  std::string host = "localhost";
  int port = 18945;
};

/// A second computer that renders the images: acus-live --make-images.
struct ImagesFrom {
  std::string host = "localhost";
  int port = 18946;
};

struct TrackerConfig {
  tracking::IgtlOptions options;
  double stale_s = 0.2;  ///< Images older than this count as missing.
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
  /// Pose of each haptic device. mm.
  std::map<std::string, Eigen::Isometry3d> reference_from_device;
  std::vector<TrackerConfig> trackers;
  std::optional<CameraConfig> camera;
  std::optional<BeltConfig> belt;
  std::optional<SendOut> send_out;
  std::optional<ImagesFrom> images_from;

  /// The index of the tracker with the tool of that name (the camera comes after the others), and
  /// the tool's index in it.
  struct Place {
    std::size_t tracker = 0;
    std::size_t tool = 0;
    double stale_s = 0.0;
  };
  std::optional<Place> FindTracked(const std::string& tool) const;

  bool has_needle() const { return !haptics.needle.device.empty() || FindTracked("needle"); }
  bool has_probe() const { return !haptics.probe.device.empty() || FindTracked("probe"); }
};

/// @throws InputError for errors against the schema and those of haptics::ReadDevices(); a tool
///     that is on a device and tracked as well, or tracked twice; a transform file that is not
///     readable; no device or tracker with a needle or probe.
LiveDevices ReadLiveDevices(const std::filesystem::path& path);

}  // namespace acus::live
