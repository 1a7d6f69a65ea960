#include "acus/rig/haptics/dhd_api.h"

#include <array>

#include "acus/base/core/error.h"

namespace acus::haptics::dhd {

LibraryRequest Library(const std::string& library, double timeout_s) {
  return {.product = "Force Dimension SDK",
          .path = library,
          .names = {"libdhd.so.3", "libdrd.so.3", "libdhd.so", "libdrd.so"},
          .preload = {},
          .shares_symbols = false,
          .advice =
              "Install the SDK of Force Dimension (for a Novint Falcon, too), or name the file "
              "under 'library' in the devices file",
          .timeout_s = timeout_s};
}

Api Load(const std::string& library, double timeout_s) {
  Api api;
  const auto symbols = [&api](const char* orientation) {
    return std::array{Required("dhdGetDeviceCount", api.GetDeviceCount),
                      Required("dhdOpenID", api.OpenId),
                      Optional("dhdOpenSerial", api.OpenSerial),
                      Required("dhdClose", api.Close),
                      Required("dhdStop", api.Stop),
                      Optional("dhdGetSystemName", api.GetSystemName),
                      Required("dhdGetSystemType", api.GetSystemType),
                      Optional("dhdGetSerialNumber", api.GetSerialNumber),
                      Required("dhdGetPosition", api.GetPosition),
                      Optional(orientation, api.GetOrientationFrame),
                      Required("dhdGetLinearVelocity", api.GetLinearVelocity),
                      Optional("dhdGetAngularVelocityRad", api.GetAngularVelocityRad),
                      Required("dhdSetForce", api.SetForce),
                      Optional("dhdSetForceAndTorque", api.SetForceAndTorque),
                      Optional("dhdGetButtonMask", api.GetButtonMask),
                      Required("dhdGetButton", api.GetButton),
                      Required("dhdEnableForce", api.EnableForce),
                      Optional("dhdSetGravityCompensation", api.SetGravityCompensation),
                      Optional("dhdSetMaxForce", api.SetMaxForce),
                      Optional("dhdSetWatchdog", api.SetWatchdog),
                      Optional("dhdGetStatus", api.GetStatus),
                      Required("dhdErrorGetLast", api.ErrorGetLast),
                      Optional("dhdErrorGetLastStr", api.ErrorGetLastStr)};
  };
  const LibraryRequest request = Library(library, timeout_s);
  LoadLibrary(request, symbols("dhdGetOrientationFrame"));
  // The name that it had before version 3.
  if (api.GetOrientationFrame == nullptr) LoadLibrary(request, symbols("dhdGetRotatorMatrix"));
  return api;
}

DriverFault KindOf(int error) noexcept {
  switch (error) {
    case 0:
      return DriverFault::kNone;
    case kErrorGeometry:
    case kErrorNotImplemented:
    case kOwnSaturated:
      return DriverFault::kWarning;
    case kErrorOutOfMemory:
    case kErrorRedundantFail:
      return DriverFault::kFatal;
    default:
      break;
  }
  return error >= kOwnForceOff ? DriverFault::kWarning : DriverFault::kReopen;
}

std::string Text(int error) {
  switch (error) {
    case kErrorCom:
      return "communication with the device was lost: is its cable plugged in?";
    case kErrorBusy:
      return "the device's controller is busy";
    case kErrorNoDevice:
      return "there is no device: is it plugged in and switched on?";
    case kErrorNotAvailable:
    case kErrorInUse:
      return "the device is in use: close other programs that use it";
    case kErrorTimeout:
      return "the device does not answer in time: is its cable plugged in?";
    case kErrorGeometry:
      return "the pose cannot be computed: move the handle to the middle";
    case kErrorNotImplemented:
      return "the device does not do what was asked of it";
    case kErrorOutOfMemory:
      return "the vendor's library is out of memory";
    case kErrorRedundantFail:
      return "the device's two position sensors disagree: it must be repaired";
    case kOwnSaturated:
      return "a motor gives all that it has";
    case kOwnStatusError:
      return "the device reports an error of its own";
    case kOwnForceOff + 1:
      return "forces are off: the force button of the device was pressed";
    case kOwnForceOff + 2:
      return "forces were off: the handle moved too fast";
    case kOwnForceOff + 3:
      return "forces were off: the device's watchdog had not been served";
    case kOwnForceOff + 6:
      return "forces are off: the device's dead-man switch is open";
    default:
      break;
  }
  if (error >= kOwnForceOff) return "forces were switched off by the device";
  return Message("error ", error, " of the vendor's library");
}

Model ModelOf(int type) noexcept {
  switch (type) {
    case 33:
      return {"omega.3", 12.0, 0.0, false};
    case 34:
    case 36:
      return {"omega.6", 12.0, 0.0, true};
    case 35:
    case 37:
      return {"omega.7", 12.0, 0.0, true};
    case 63:
      return {"delta.3", 20.0, 0.0, false};
    case 104:
    case 105:
      return {"sigma.7", 12.0, 200.0, true};
    case 206:
      return {"sigma.3", 12.0, 0.0, false};
    case 108:
    case 109:
      return {"lambda.7", 12.0, 200.0, true};
    case 131:
    case 132:
      return {"lambda.6", 12.0, 0.0, true};
    case 203:
      return {"lambda.3", 12.0, 0.0, false};
    case 60:
      return {"Novint Falcon", 8.0, 0.0, false};
    default:
      return {"device of Force Dimension", 8.0, 0.0, true};
  }
}

}  // namespace acus::haptics::dhd
