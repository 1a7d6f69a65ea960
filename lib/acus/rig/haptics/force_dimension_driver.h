// omega, delta, sigma, lambda and Novint Falcon devices, by the Force Dimension SDK.
#pragma once

#include <memory>

#include "acus/rig/haptics/driver.h"
#include "acus/rig/haptics/vendor_options.h"

namespace acus::haptics {

/// Loads the library. `options.device` is a serial number, or empty for the first device that is
/// free. The servo is a thread of ours at options.rate_hz. @throws InputError
std::unique_ptr<Driver> ForceDimensionDriver(const VendorOptions& options);

}  // namespace acus::haptics
