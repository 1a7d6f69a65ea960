// Virtuose devices of Haption, by VirtuoseAPI 4.
#pragma once

#include <memory>

#include "acus/rig/haptics/driver.h"
#include "acus/rig/haptics/vendor_options.h"

namespace acus::haptics {

/// Loads the library. `options.device` is the address, "192.168.1.2" or "127.0.0.1#53210" (which is
/// taken if it is empty). The servo is the vendor's loop at options.rate_hz. @throws InputError
std::unique_ptr<Driver> VirtuoseDriver(const VendorOptions& options);

}  // namespace acus::haptics
