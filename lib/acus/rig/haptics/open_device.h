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

/// The same as far as it goes without running any code of the vendor's: the library is looked for,
/// but not loaded, and no process is started. Its info() names the file; it cannot be started. A
/// virtual hand is opened as it is.
/// @throws InputError, which names the device: the library is not there or may not be loaded, or a
///     setting is not allowed.
std::unique_ptr<HapticDevice> CheckDevice(const DeviceConfig& config);

}  // namespace acus::haptics
