#include "acus/rig/tracking/trackers_file.h"

#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/error.h"

namespace acus::tracking {
namespace {

using nlohmann::json;

IgtlTool ToolOf(const json& node, const std::string& where) {
  IgtlTool tool{.tool = node.at("tool"),
                .device = node.at("device"),
                .relative_to = node.at("relative_to"),
                .marker_from_tool = config::PoseFrom(node, where)};
  ACUS_REQUIRE(tool.relative_to != tool.device, where, "/relative_to: is '", tool.relative_to,
               "', the device itself");
  return tool;
}

}  // namespace

std::vector<IgtlOptions> ReadTrackers(const std::filesystem::path& path) {
  const json document = config::ReadConfig(path, "acus-devices");
  const json& nodes = document.at("trackers");
  std::vector<IgtlOptions> trackers;
  std::set<std::string> names;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const json& node = nodes[i];
    const std::string where = Message(path.string(), ": /trackers/", i);
    IgtlOptions options;
    options.name = node.at("name");
    options.host = node.at("host");
    options.port = node.at("port");
    options.listen = node.at("listen");
    options.tdata_interval_ms = node.at("request_interval_ms");
    options.check_crc = node.at("check_crc");
    options.lost_after_ms = node.at("lost_after_ms");
    options.silence_ms = node.at("silence_ms");
    const json& tools = node.at("tools");
    for (std::size_t k = 0; k < tools.size(); ++k) {
      const std::string place = Message(where, "/tools/", k);
      options.tools.push_back(ToolOf(tools[k], place));
      ACUS_REQUIRE(names.insert(options.tools.back().tool).second, place, "/tool: there are two '",
                   options.tools.back().tool, "'; a tool comes from one place");
    }
    trackers.push_back(std::move(options));
  }
  return trackers;
}

}  // namespace acus::tracking
