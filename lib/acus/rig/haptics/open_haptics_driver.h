// Touch, Touch X and Phantom devices of 3D Systems, by OpenHaptics.
#pragma once

#include <memory>

#include "acus/rig/haptics/driver.h"
#include "acus/rig/haptics/vendor_options.h"

namespace acus::haptics {

/// Loads the library. Several devices share the vendor's scheduler: it is stopped with the last.
/// @throws InputError
std::unique_ptr<Driver> OpenHapticsDriver(const VendorOptions& options);

}  // namespace acus::haptics
