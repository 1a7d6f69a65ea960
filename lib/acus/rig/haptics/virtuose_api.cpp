#include "acus/rig/haptics/virtuose_api.h"

#include <array>

#include "acus/base/core/error.h"

namespace acus::haptics::virtuose {

LibraryRequest Library(const std::string& library, double timeout_s) {
  return {.product = "VirtuoseAPI",
          .path = library,
          .names = {"libVirtuoseAPI.so", "virtuoseAPI.so"},
          .preload = {},
          .shares_symbols = false,
          .advice =
              "Install VirtuoseAPI 4 of Haption, or name the file under 'library' in the "
              "devices file",
          .timeout_s = timeout_s};
}

Api Load(const std::string& library, double timeout_s) {
  const LibraryRequest request = Library(library, timeout_s);
  Api api;
  void* version_3 = nullptr;
  const std::array look = {
      Optional("virtOpen", api.Open),
      Symbol{.name = "virtCallDLL", .pointer = &version_3, .is_required = false}};
  LoadLibrary(request, look);
  ACUS_REQUIRE(api.Open != nullptr || version_3 == nullptr,
               "VirtuoseAPI: this is version 3, which is not supported: install version 4");
  const std::array symbols = {Required("virtOpen", api.Open),
                              Required("virtClose", api.Close),
                              Optional("virtAPIVersion", api.ApiVersion),
                              Optional("virtGetDeviceID", api.GetDeviceId),
                              Required("virtSetCommandType", api.SetCommandType),
                              Required("virtSetIndexingMode", api.SetIndexingMode),
                              Required("virtSetForceFactor", api.SetForceFactor),
                              Required("virtSetSpeedFactor", api.SetSpeedFactor),
                              Required("virtSetTimeStep", api.SetTimeStep),
                              Required("virtSetBaseFrame", api.SetBaseFrame),
                              Required("virtSetPowerOn", api.SetPowerOn),
                              Required("virtGetEmergencyStop", api.GetEmergencyStop),
                              Required("virtGetDeadMan", api.GetDeadMan),
                              Required("virtGetButton", api.GetButton),
                              Required("virtGetPosition", api.GetPosition),
                              Required("virtGetSpeed", api.GetSpeed),
                              Required("virtSetForce", api.SetForce),
                              Required("virtSetPeriodicFunction", api.SetPeriodicFunction),
                              Required("virtStartLoop", api.StartLoop),
                              Required("virtStopLoop", api.StopLoop),
                              Optional("virtSaturateTorque", api.SaturateTorque),
                              Optional("virtGetAlarm", api.GetAlarm),
                              Optional("virtSetTimeoutValue", api.SetTimeoutValue),
                              Required("virtGetErrorCode", api.GetErrorCode)};
  LoadLibrary(request, symbols);
  return api;
}

DriverFault KindOf(int error) noexcept {
  switch (error) {
    case 0:
      return DriverFault::kNone;
    case kNotImplemented:
    case kNotAvailable:
    case kPositionDiscontinuity:
    case kOwnEmergencyStop:
    case kOwnDeadMan:
    case kOwnOverheat:
    case kOwnSaturated:
    case kOwnPowerOff:
      return DriverFault::kWarning;
    case kOutOfMemory:
    case kMajorMinorVersion:
    case kWrongMode:
    case kModeNotSupported:
    case kIncompatibleVersion:
      return DriverFault::kFatal;
    default:
      return DriverFault::kReopen;
  }
}

std::string Text(int error) {
  switch (error) {
    case kOutOfMemory:
      return "the vendor's library is out of memory";
    case kCommunicationFailure:
    case kTimeOut:
      return "communication with the device was lost: is its network cable plugged in, and its "
             "address right?";
    case kHardwareError:
      return "the device reports a fault of its hardware: switch it off and on";
    case kPositionDiscontinuity:
      return "the position jumped";
    case kMajorMinorVersion:
    case kIncompatibleVersion:
      return "the device and VirtuoseAPI are of versions that do not fit";
    case kWrongMode:
    case kModeNotSupported:
      return "the device cannot be driven by forces";
    case kOwnEmergencyStop:
      return "the emergency stop is pressed: turn it to release it";
    case kOwnDeadMan:
      return "the dead-man switch of the handle is open: hold the handle";
    case kOwnOverheat:
      return "its motors are hot: let it rest";
    case kOwnSaturated:
      return "a motor gives all that it has";
    case kOwnPowerOff:
      return "its motors have no power";
    default:
      return Message("error ", error, " of the vendor's library");
  }
}

}  // namespace acus::haptics::virtuose
