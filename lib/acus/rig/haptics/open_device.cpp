#include "acus/rig/haptics/open_device.h"

#include <utility>

#include "acus/base/core/error.h"
#include "acus/rig/haptics/dhd_api.h"
#include "acus/rig/haptics/force_dimension_driver.h"
#include "acus/rig/haptics/hd_api.h"
#include "acus/rig/haptics/open_haptics_driver.h"
#include "acus/rig/haptics/unloaded_driver.h"
#include "acus/rig/haptics/virtual_hand_driver.h"
#include "acus/rig/haptics/virtuose_api.h"
#include "acus/rig/haptics/virtuose_driver.h"

namespace acus::haptics {
namespace {

std::unique_ptr<Driver> DriverFor(const DeviceConfig& config,
                                  std::shared_ptr<HandSteering> steering) {
  switch (config.driver) {
    case DriverKind::kOpenHaptics:
      return OpenHapticsDriver(config.vendor);
    case DriverKind::kForceDimension:
      return ForceDimensionDriver(config.vendor);
    case DriverKind::kVirtuose:
      return VirtuoseDriver(config.vendor);
    case DriverKind::kVirtualHand:
      break;
  }
  return std::make_unique<VirtualHandDriver>(config.hand, std::move(steering));
}

std::unique_ptr<Driver> UnloadedDriverFor(const DeviceConfig& config) {
  const VendorOptions& vendor = config.vendor;
  LibraryRequest request;
  switch (config.driver) {
    case DriverKind::kOpenHaptics:
      request = hd::Library(vendor.library, vendor.timeout_s);
      break;
    case DriverKind::kForceDimension:
      request = dhd::Library(vendor.library, vendor.timeout_s);
      break;
    case DriverKind::kVirtuose:
      request = virtuose::Library(vendor.library, vendor.timeout_s);
      break;
    case DriverKind::kVirtualHand:
      return DriverFor(config, nullptr);
  }
  DeviceInfo info;
  info.name = Message(request.product, " of ", FindLibrary(request).string(),
                      " (there, not loaded; the device was not looked for)");
  info.max_force_n = config.safety.max_force_n;
  info.max_torque_nmm = config.safety.max_torque_nmm;
  info.rate_hz = vendor.rate_hz;
  return std::make_unique<UnloadedDriver>(std::move(info));
}

/// The device of `driver()`; what goes wrong names it.
template <typename MakeDriver>
std::unique_ptr<HapticDevice> DeviceOf(const DeviceConfig& config, const MakeDriver& driver) {
  try {
    return std::make_unique<HapticDevice>(driver(), config.safety);
  } catch (const InputError& error) {
    throw InputError(Message("device '", config.name, "': ", error.what()));
  }
}

}  // namespace

std::unique_ptr<HapticDevice> OpenDevice(const DeviceConfig& config,
                                         std::shared_ptr<HandSteering> steering) {
  return DeviceOf(config, [&] { return DriverFor(config, std::move(steering)); });
}

std::unique_ptr<HapticDevice> CheckDevice(const DeviceConfig& config) {
  return DeviceOf(config, [&] { return UnloadedDriverFor(config); });
}

}  // namespace acus::haptics
