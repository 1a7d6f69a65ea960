// From a devices file to a device that can be started.
#pragma once

#include <memory>

#include "acus/rig/haptics/devices_file.h"
#include "acus/rig/haptics/haptic_device.h"

namespace acus::haptics {

/// Loads the vendor's library, finds the device, and puts the guard before it. Motors are off.
/// @param steering  of a virtual hand; may be null.  @throws InputError, which names the device.
std::unique_ptr<HapticDevice> OpenDevice(const DeviceConfig& config,
                                         std::shared_ptr<HandSteering> steering = nullptr);

}  // namespace acus::haptics
