#include "acus/run/live/live_devices.h"

#include <cmath>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/error.h"
#include "acus/data/transforms/transform_file.h"
#include "acus/rig/tracking/trackers_file.h"

namespace acus::live {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

Eigen::Vector3d VectorOf(const json& node) {
  const auto v = node.get<std::vector<double>>();
  return {v[0], v[1], v[2]};
}

Eigen::Isometry3d PlaceOf(const json& device, const fs::path& folder, const std::string& where) {
  const std::string file = device.at("reference_from_device_file");
  if (!file.empty()) return transforms::ReadTransform(folder / file);
  return config::PoseFrom(device.at("reference_from_device"), where + "/reference_from_device");
}

BeltConfig BeltOf(const json& node, const std::string& where) {
  BeltConfig belt{.tool = node.at("tool"),
                  .axis = VectorOf(node.at("axis")),
                  .expiration_mm = node.at("expiration_mm"),
                  .inspiration_mm = node.at("inspiration_mm")};
  ACUS_REQUIRE(belt.axis.norm() > 1e-6, where, "/axis: has no length");
  ACUS_REQUIRE(std::abs(belt.inspiration_mm - belt.expiration_mm) > 0.1, where,
               ": inspiration_mm and expiration_mm must be at least 0.1 mm apart");
  belt.axis.normalize();
  return belt;
}

constexpr double kFilmRateHz = 30.0;  ///< Frame rate of videos and folders in place of a camera.

camera::SecondCameraOptions SecondOf(const json& node, const fs::path& folder) {
  return {
      .place = node.at("place"),
      .pair = camera::ReadStereo(config::FindConfig(node.at("stereo").get<std::string>(), folder)),
      .apart_ms = node.at("apart_ms")};
}

CameraConfig CameraOf(const json& node, const fs::path& folder, const std::string& where) {
  CameraConfig camera;
  camera.model = config::FindConfig(node.at("model").get<std::string>(), folder);
  camera.facets = config::FindConfig(node.at("facets").get<std::string>(), folder);
  camera.stale_s = node.at("stale_s");
  camera::CameraTrackerOptions& options = camera.options;
  options.name = node.at("name");
  options.place = node.at("place");
  options.source.pace_hz = kFilmRateHz;
  options.reference = node.at("reference");
  options.hold_reference_ms = node.at("hold_reference_ms");
  options.journal_capacity = 1U << 12;
  if (node.contains("second")) options.second = SecondOf(node.at("second"), folder);
  const json& tools = node.at("tools");
  for (std::size_t i = 0; i < tools.size(); ++i) {
    options.tools.push_back(
        {.tool = tools[i].at("tool"),
         .object = tools[i].at("object"),
         .object_from_tool = config::PoseFrom(tools[i], Message(where, "/tools/", i))});
  }
  return camera;
}

void CheckTools(const LiveDevices& devices, const std::string& file) {
  std::map<std::string, int> tracked;
  for (const TrackerConfig& tracker : devices.trackers) {
    for (const tracking::IgtlTool& tool : tracker.options.tools) {
      ACUS_REQUIRE(++tracked[tool.tool] == 1, file, ": /trackers: tool \"", tool.tool,
                   "\" is tracked twice; name another one otherwise");
    }
  }
  for (std::size_t i = 0; devices.camera && i < devices.camera->options.tools.size(); ++i) {
    const std::string& tool = devices.camera->options.tools[i].tool;
    ACUS_REQUIRE(++tracked[tool] == 1, file, ": /camera/tools: tool \"", tool,
                 "\" is tracked twice; name another one otherwise");
  }
  for (const auto& [tool, config] :
       {std::pair{"needle", &devices.haptics.needle}, {"probe", &devices.haptics.probe}}) {
    ACUS_REQUIRE(config->device.empty() || !devices.FindTracked(tool), file, ": the ", tool,
                 " is on the device \"", config->device, "\" and tracked as well; leave one out");
  }
  ACUS_REQUIRE(devices.has_needle() || devices.has_probe(), file,
               ": neither needle nor probe is on a device or tracked; give /needle/device, or a "
               "tool \"needle\" or \"probe\" in /trackers");
  ACUS_REQUIRE(!devices.belt || devices.FindTracked(devices.belt->tool), file,
               ": /breath/tool: no "
               "tracker has a tool \"",
               devices.belt ? devices.belt->tool : "", "\"");
}

}  // namespace

std::optional<LiveDevices::Place> LiveDevices::FindTracked(const std::string& tool) const {
  for (std::size_t t = 0; t < trackers.size(); ++t) {
    const auto& tools = trackers[t].options.tools;
    for (std::size_t i = 0; i < tools.size(); ++i) {
      if (tools[i].tool == tool) return Place{t, i, trackers[t].stale_s};
    }
  }
  for (std::size_t i = 0; camera && i < camera->options.tools.size(); ++i) {
    if (camera->options.tools[i].tool == tool) return Place{trackers.size(), i, camera->stale_s};
  }
  return {};
}

LiveDevices ReadLiveDevices(const fs::path& path) {
  LiveDevices devices;
  devices.haptics = haptics::ReadDevices(path);
  devices.name = devices.haptics.name;
  const json document = config::ReadConfig(path, "acus-devices");
  const std::string file = path.string();
  const json& list = document.at("devices");
  for (std::size_t i = 0; i < list.size(); ++i) {
    devices.reference_from_device[list[i].at("name")] =
        PlaceOf(list[i], path.parent_path(), Message(file, ": /devices/", i));
  }
  for (tracking::IgtlOptions& options : tracking::ReadTrackers(path)) {
    options.journal_capacity = 1U << 15;
    devices.trackers.push_back(
        {.options = options, .stale_s = 1e-3 * static_cast<double>(options.lost_after_ms)});
  }
  if (document.contains("camera")) {
    devices.camera = CameraOf(document.at("camera"), path.parent_path(), file + ": /camera");
  }
  if (document.contains("breath")) {
    devices.belt = BeltOf(document.at("breath"), file + ": /breath");
  }
  if (document.contains("send_out")) {
    const json& out = document.at("send_out");
    devices.send_out = SendOut{.host = out.at("host"), .port = out.at("port")};
  }
  if (document.contains("images_from")) {
    const json& from = document.at("images_from");
    devices.images_from = ImagesFrom{.host = from.at("host"), .port = from.at("port")};
  }
  CheckTools(devices, file);
  return devices;
}

}  // namespace acus::live
