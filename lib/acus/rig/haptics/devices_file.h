// Files of configs/devices (format acus-devices/1): what is attached, and what it is for. Other
// modules read their own sections of the same file.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/rig/haptics/force_guard.h"
#include "acus/rig/haptics/vendor_options.h"
#include "acus/rig/haptics/virtual_hand.h"

namespace acus::haptics {

enum class DriverKind { kVirtualHand, kOpenHaptics, kForceDimension, kVirtuose };

struct DeviceConfig {
  std::string name;
  DriverKind driver = DriverKind::kVirtualHand;
  VendorOptions vendor;
  GuardSettings safety;
  VirtualHandSettings hand;
};

/// Which device a tool is on, and how it is fixed to the handle.
struct ToolConfig {
  std::string device;                                                  ///< Empty: none.
  Eigen::Isometry3d handle_from_tool = Eigen::Isometry3d::Identity();  ///< mm.
};

struct DevicesFile {
  std::string name;
  std::vector<DeviceConfig> devices;
  ToolConfig needle;  ///< left_handed is heeded already.
  ToolConfig probe;

  /// The device of that name; null if there is none.
  const DeviceConfig* Find(const std::string& device) const;
  /// Needle and probe change hands: the devices change, what is fixed to the handle goes along.
  void SwapHands();
};

/// @throws InputError: what the schema says; a library that is neither an absolute path nor a name
///     without a slash (see trusted_library.h for the file itself); two devices of one name; needle
///     or probe on a device that is not there, or both on the same.
DevicesFile ReadDevices(const std::filesystem::path& path);

}  // namespace acus::haptics
