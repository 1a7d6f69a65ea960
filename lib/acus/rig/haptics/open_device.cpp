#include "acus/rig/haptics/open_device.h"

#include <utility>

#include "acus/base/core/error.h"
#include "acus/rig/haptics/driver.h"
#include "acus/rig/haptics/force_dimension_driver.h"
#include "acus/rig/haptics/open_haptics_driver.h"
#include "acus/rig/haptics/virtual_hand_driver.h"
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

}  // namespace

std::unique_ptr<HapticDevice> OpenDevice(const DeviceConfig& config,
                                         std::shared_ptr<HandSteering> steering) {
  try {
    return std::make_unique<HapticDevice>(DriverFor(config, std::move(steering)), config.safety);
  } catch (const InputError& error) {
    throw InputError(Message("device '", config.name, "': ", error.what()));
  }
}

}  // namespace acus::haptics
