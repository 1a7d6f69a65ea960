#include "acus/rig/haptics/devices_file.h"

#include <numbers>
#include <utility>

#include "acus/base/config/json_file.h"
#include "acus/base/config/pose_json.h"
#include "acus/base/core/error.h"
#include "acus/base/core/trusted_library.h"
#include "acus/rig/haptics/axes.h"

namespace acus::haptics {
namespace {

using nlohmann::json;

constexpr double kRadPerDeg = std::numbers::pi / 180.0;

DriverKind DriverOf(const std::string& word) {
  if (word == "openhaptics") return DriverKind::kOpenHaptics;
  if (word == "force_dimension") return DriverKind::kForceDimension;
  if (word == "virtuose") return DriverKind::kVirtuose;
  return DriverKind::kVirtualHand;
}

DeadMan DeadManOf(const std::string& word) {
  if (word == "button") return DeadMan::kButton;
  return word == "pedal" ? DeadMan::kPedal : DeadMan::kNone;
}

GuardSettings SafetyOf(const json& node) {
  GuardSettings safety;
  safety.max_force_n = node.at("max_force_n");
  safety.max_torque_nmm = node.at("max_torque_nmm");
  safety.force_slew_n_per_s = node.at("force_slew_n_per_s");
  safety.torque_slew_nmm_per_s = node.at("torque_slew_nmm_per_s");
  safety.ramp_in_s = node.at("ramp_in_s");
  safety.settle_s = node.at("settle_s");
  safety.late_s = node.at("late_s");
  safety.continuous_force_n = node.at("continuous_force_n");
  safety.continuous_over_s = node.at("continuous_over_s");
  safety.jump_mm = node.at("jump_mm");
  safety.jump_rad = node.at("jump_deg").get<double>() * kRadPerDeg;
  safety.dead_man = DeadManOf(node.at("dead_man"));
  safety.dead_man_buttons = 0;
  for (const unsigned button : node.at("dead_man_buttons").get<std::vector<unsigned>>()) {
    safety.dead_man_buttons |= 1U << button;
  }
  return safety;
}

VirtualHandSettings HandOf(const json& node, double rate_hz, const std::string& where) {
  VirtualHandSettings hand;
  hand.mass_kg = node.at("mass_kg");
  hand.damping_n_s_per_m = node.at("damping_n_s_per_m");
  hand.stiffness_n_per_m = node.at("stiffness_n_per_m");
  hand.grip_damping_n_s_per_m = node.at("grip_damping_n_s_per_m");
  hand.inertia_kg_mm2 = node.at("inertia_kg_mm2");
  hand.grip_torque_nmm_per_rad = node.at("grip_torque_nmm_per_rad");
  hand.tremor_mm = node.at("tremor_mm");
  hand.encoder_mm = node.at("encoder_mm");
  hand.max_force_n = node.at("max_force_n");
  hand.max_torque_nmm = node.at("max_torque_nmm");
  hand.rate_hz = rate_hz;
  hand.path.repeats = node.at("repeats");
  const json& path = node.at("path");
  for (std::size_t i = 0; i < path.size(); ++i) {
    const std::string place = Message(where, "/path/", i);
    hand.path.points.push_back({path[i].at("time_s"), config::PoseFrom(path[i], place)});
    ACUS_REQUIRE(i == 0 || hand.path.points[i].time_s > hand.path.points[i - 1].time_s, place,
                 "/time_s: is ", hand.path.points[i].time_s,
                 " s, not after the point before it; times must increase");
  }
  return hand;
}

DeviceConfig DeviceOf(const json& node, const std::string& where) {
  DeviceConfig device;
  device.name = node.at("name");
  device.driver = DriverOf(node.at("driver"));
  device.vendor = {.library = node.at("library"),
                   .device = node.at("device"),
                   .axes = node.at("axes"),
                   .rate_hz = node.at("rate_hz"),
                   .timeout_s = node.at("timeout_s")};
  CheckLibraryWord(device.vendor.library, where + "/library");
  if (!device.vendor.axes.empty()) Axes(device.vendor.axes, where + "/axes");
  device.safety = SafetyOf(node.at("safety"));
  device.hand = HandOf(node.at("virtual_hand"), device.vendor.rate_hz, where + "/virtual_hand");
  return device;
}

ToolConfig ToolOf(const json& node, const std::string& where, const DevicesFile& file) {
  ToolConfig tool{.device = node.at("device"), .handle_from_tool = config::PoseFrom(node, where)};
  std::string names;
  for (const DeviceConfig& device : file.devices) names += " '" + device.name + "'";
  ACUS_REQUIRE(tool.device.empty() || file.Find(tool.device) != nullptr, where, "/device: is '",
               tool.device, "'; the devices are", names.empty() ? " none" : names);
  return tool;
}

}  // namespace

const DeviceConfig* DevicesFile::Find(const std::string& device) const {
  for (const DeviceConfig& candidate : devices) {
    if (candidate.name == device) return &candidate;
  }
  return nullptr;
}

void DevicesFile::SwapHands() {
  std::swap(needle.device, probe.device);
}

DevicesFile ReadDevices(const std::filesystem::path& path) {
  const json document = config::ReadConfig(path, "acus-devices");
  DevicesFile file;
  file.name = document.at("name");
  const json& devices = document.at("devices");
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const std::string where = Message(path.string(), ": /devices/", i);
    DeviceConfig device = DeviceOf(devices[i], where);
    ACUS_REQUIRE(file.Find(device.name) == nullptr, where, "/name: there are two devices '",
                 device.name, "'");
    file.devices.push_back(std::move(device));
  }
  file.needle = ToolOf(document.at("needle"), path.string() + ": /needle", file);
  file.probe = ToolOf(document.at("probe"), path.string() + ": /probe", file);
  ACUS_REQUIRE(file.needle.device.empty() || file.needle.device != file.probe.device, path.string(),
               ": /probe/device: the device '", file.probe.device, "' holds the needle already");
  if (document.at("left_handed").get<bool>()) file.SwapHands();
  return file;
}

}  // namespace acus::haptics
