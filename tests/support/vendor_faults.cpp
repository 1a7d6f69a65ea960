#include "support/vendor_faults.h"

namespace acus::testing_support {
namespace {

using haptics::DriverKind;
using haptics::GuardAct;
using enum Outcome;

constexpr auto kHd = DriverKind::kOpenHaptics;
constexpr auto kDhd = DriverKind::kForceDimension;
constexpr auto kVirt = DriverKind::kVirtuose;

const char* Product(DriverKind driver) {
  switch (driver) {
    case kHd:
      return "OpenHaptics";
    case kDhd:
      return "DHD";
    default:
      return "Virtuose";
  }
}

const char* Words(Outcome outcome) {
  switch (outcome) {
    case kRefused:
      return "refused before any motor is on";
    case kRunsOn:
      return "runs on";
    case kReopened:
      return "zero force, opened again, ramp-in";
    case kKeepsTrying:
      return "zero force; opened again as soon as it is there";
    case kEnds:
      return "zero force, halted";
    case kNoForce:
      return "runs, no force";
  }
  return "";
}

std::vector<VendorFault> OpenHapticsFaults() {
  return {
      {kHd, "NoFault", "none", "hd", "", kRunsOn},
      {kHd, "CommError", "COMM_ERROR after 300 ticks", "hd", "error_at=300,error=770", kReopened,
       "communication with the device was lost"},
      {kHd, "CommErrorThrice", "COMM_ERROR again after it was opened again", "hd",
       "error_at=200,error=770,error_times=3", kReopened, "communication with the device was lost"},
      {kHd, "Unplugged", "cable pulled after 300 ticks", "hd", "unplugged=300", kKeepsTrying,
       "is it plugged in"},
      {kHd, "AlreadyInitiated", "DEVICE_ALREADY_INITIATED twice", "hd", "already_initiated=2",
       kRunsOn},
      {kHd, "AlreadyInitiatedForEver", "DEVICE_ALREADY_INITIATED for ever", "hd",
       "already_initiated=1e9", kRefused, "the device is in use: close other programs"},
      {kHd, "NullName", "the default device has another name", "hd", "no_null_name=1", kRunsOn},
      {kHd, "NoDevice", "no device", "hd", "no_device=1", kRefused, "is it plugged in"},
      {kHd, "Licence", "licence not valid", "hd", "license=1", kRefused, "licence"},
      {kHd, "Jitter", "servo comes 0.2 to 20 ms after the last time", "hd", "jitter=1", kRunsOn, "",
       GuardAct::kReadingLate},
      {kHd, "NanPose", "a NaN in a pose", "hd", "nan_pose=300", kRunsOn, "",
       GuardAct::kReadingNotFinite},
      {kHd, "InfPose", "an infinity in a pose", "hd", "inf_pose=300", kRunsOn, "",
       GuardAct::kReadingNotFinite},
      {kHd, "Jump", "pose jumps by 50 mm", "hd", "jump=300", kRunsOn, "", GuardAct::kReadingJumped},
      {kHd, "Skew", "rotation not orthonormal by 0.4 %", "hd", "skew=0.004", kRunsOn},
      {kHd, "NoRotation", "rotation of zeros", "hd", "no_rotation=300", kRunsOn, "",
       GuardAct::kReadingNotFinite},
      {kHd, "StuckButton", "dead-man button stuck from the start", "hd", "stuck_button=1", kNoForce,
       "", GuardAct::kDeadManOpen, true},
      {kHd, "Button", "dead-man button held after 100 ticks", "hd", "button_from=100", kRunsOn, "",
       GuardAct::kDeadManOpen, true},
      {kHd, "WithoutRequired", "a function is missing: hdScheduleAsynchronous",
       "hd_without_required", "", kRefused, "hdScheduleAsynchronous"},
      {kHd, "WithoutOptional", "functions that are not needed are missing", "hd_without_optional",
       "", kRunsOn},
      {kHd, "HangsWhenLoaded", "library hangs while it is loaded", "hd", "hang_constructor=1",
       kRefused, "does not return from loading"},
      {kHd, "AbortsWhenLoaded", "library aborts while it is loaded", "hd", "abort_constructor=1",
       kRefused, "crashes while it is loaded"},
      {kHd, "HangsInInit", "hdInitDevice never returns", "hd", "hang_open=1", kRefused,
       "hdInitDevice of OpenHaptics does not return"},
      {kHd, "UnknownError", "an error number that is not known", "hd", "error_at=300,error=1911",
       kReopened, "an error that is not known (error 0x777"},
      {kHd, "EndlessErrors", "hdGetError never ends", "hd", "endless_errors=1", kRefused,
       "errors without end"},
      {kHd, "Calibration", "calibration needed", "hd", "calibration=1", kRunsOn},
      {kHd, "CalibrationByHand", "calibration needed, by hand", "hd", "calibration=2", kRefused,
       "put the stylus into its inkwell"},
      {kHd, "WarmMotors", "WARM_MOTORS 20 times", "hd", "error_at=300,error=512,error_times=20",
       kRunsOn, "its motors are warm"},
      {kHd, "ExceededForce", "EXCEEDED_MAX_FORCE", "hd", "error_at=300,error=513", kRunsOn,
       "more force was requested than it has"},
      {kHd, "LoopDies", "the vendor's scheduler stops calling", "hd", "loop_dies=300", kReopened,
       "stopped answering"},
      {kHd, "NoCallback", "the scheduler is full", "hd", "no_callback=1", kRefused, "0x501"},
      {kHd, "DisableFails", "hdDisableDevice fails", "hd", "disable_fails=1", kRunsOn},
  };
}

std::vector<VendorFault> ForceDimensionFaults() {
  return {
      {kDhd, "NoFault", "none", "dhd", "", kRunsOn},
      {kDhd, "CommError", "ERROR_COM after 300 ticks", "dhd", "error_at=300,error=2", kReopened,
       "communication with the device was lost"},
      {kDhd, "Unplugged", "cable pulled after 300 ticks", "dhd", "unplugged=300", kKeepsTrying,
       "is its cable plugged in"},
      {kDhd, "TimeGuard", "TIMEGUARD at each call", "dhd", "time_guard=1", kRunsOn},
      {kDhd, "Saturated", "MOTOR_SATURATED", "dhd", "saturated=300", kRunsOn,
       "gives all that it has"},
      {kDhd, "Geometry", "ERROR_GEOMETRY for one reading", "dhd", "error_at=300,error=8", kRunsOn,
       "cannot be computed", GuardAct::kReadingInvalid},
      {kDhd, "OutOfMemory", "ERROR_OUT_OF_MEMORY", "dhd", "error_at=300,error=11", kEnds,
       "out of memory"},
      {kDhd, "SensorsDisagree", "ERROR_REDUNDANT_FAIL", "dhd", "error_at=300,error=18", kEnds,
       "sensors disagree"},
      {kDhd, "FailsWithoutNumber", "a call fails, but there is no error number", "dhd",
       "error_at=300,error=0", kReopened, "communication with the device was lost"},
      {kDhd, "VelocityCut", "the device switches forces off: too fast", "dhd",
       "force_off=300,cause=2", kRunsOn, "moved too fast", GuardAct::kMotorsOff},
      {kDhd, "ForceButton", "its force button is pressed, and again", "dhd",
       "force_off=300,cause=1,force_on=500", kRunsOn, "force button", GuardAct::kMotorsOff},
      {kDhd, "StatusError", "its status has an error", "dhd", "status_error=300", kReopened,
       "an error of its own"},
      {kDhd, "NoDevice", "no device", "dhd", "no_device=1", kRefused, "there is no device"},
      {kDhd, "InUse", "used by another program", "dhd", "in_use=1", kRefused,
       "close other programs"},
      {kDhd, "HangsInOpen", "dhdOpen never returns", "dhd", "hang_open=1", kRefused,
       "dhdOpen of Force Dimension does not return"},
      {kDhd, "HangsWhenLoaded", "library hangs while it is loaded", "dhd", "hang_constructor=1",
       kRefused, "does not return from loading"},
      {kDhd, "AbortsWhenLoaded", "library aborts while it is loaded", "dhd", "abort_constructor=1",
       kRefused, "crashes while it is loaded"},
      {kDhd, "EnableFails", "forces cannot be switched on", "dhd", "enable_fails=1", kRefused,
       "forces cannot be switched on"},
      {kDhd, "WithoutRequired", "a function is missing: dhdEnableForce", "dhd_without_required", "",
       kRefused, "dhdEnableForce"},
      {kDhd, "WithoutOptional", "functions that are not needed are missing", "dhd_without_optional",
       "", kRunsOn},
      {kDhd, "OldName", "the rotation's function has its old name", "dhd_old", "", kRunsOn},
      {kDhd, "NanPose", "a NaN in a pose", "dhd", "nan_pose=300", kRunsOn, "",
       GuardAct::kReadingNotFinite},
      {kDhd, "Jump", "pose jumps by 50 mm", "dhd", "jump=300", kRunsOn, "",
       GuardAct::kReadingJumped},
      {kDhd, "Skew", "rotation not orthonormal by 0.4 %", "dhd", "skew=0.004", kRunsOn},
      {kDhd, "StuckButton", "dead-man button stuck from the start", "dhd", "stuck_button=1",
       kNoForce, "", GuardAct::kDeadManOpen, true},
      {kDhd, "StopFails", "dhdStop fails", "dhd", "stop_fails=1", kRunsOn},
  };
}

std::vector<VendorFault> VirtuoseFaults() {
  return {
      {kVirt, "NoFault", "none", "virtuose", "", kRunsOn},
      {kVirt, "CommunicationFailure", "COMMUNICATION_FAILURE after 300 ticks", "virtuose",
       "error_at=300,error=2", kReopened, "communication with the device was lost"},
      {kVirt, "Unplugged", "cable pulled after 300 ticks", "virtuose", "unplugged=300",
       kKeepsTrying, "is its network cable plugged in"},
      {kVirt, "HardwareError", "HARDWARE_ERROR", "virtuose", "error_at=300,error=11", kReopened,
       "fault of its hardware"},
      {kVirt, "OutOfMemory", "OUT_OF_MEMORY", "virtuose", "error_at=300,error=1", kEnds,
       "out of memory"},
      {kVirt, "Discontinuity", "POSITION_DISCONTINUITY for one reading", "virtuose",
       "error_at=300,error=12", kRunsOn, "position jumped", GuardAct::kReadingInvalid},
      {kVirt, "WrongVersion", "INCOMPATIBLE_VERSION at virtOpen", "virtuose",
       "no_device=1,open_error=20", kRefused, "versions that do not fit"},
      {kVirt, "NoDevice", "no device at the address", "virtuose", "no_device=1", kRefused,
       "no device at '127.0.0.1#53210'"},
      {kVirt, "Version3", "VirtuoseAPI 3", "virtuose_3", "", kRefused, "this is version 3"},
      {kVirt, "HangsInOpen", "virtOpen never returns", "virtuose", "hang_open=1", kRefused,
       "virtOpen of VirtuoseAPI does not return"},
      {kVirt, "HangsWhenLoaded", "library hangs while it is loaded", "virtuose",
       "hang_constructor=1", kRefused, "does not return from loading"},
      {kVirt, "AbortsWhenLoaded", "library aborts while it is loaded", "virtuose",
       "abort_constructor=1", kRefused, "crashes while it is loaded"},
      {kVirt, "PowerFails", "motors get no power", "virtuose", "power_fails=1", kRefused,
       "virtSetPowerOn"},
      {kVirt, "LoopFails", "the vendor's loop cannot be started", "virtuose", "loop_fails=1",
       kRefused, "virtStartLoop"},
      {kVirt, "LoopDies", "the vendor's loop stops calling", "virtuose", "loop_dies=300", kReopened,
       "stopped answering"},
      {kVirt, "StopFails", "virtStopLoop fails", "virtuose", "stop_fails=1", kRunsOn},
      {kVirt, "Overheat", "alarm: motors too hot", "virtuose", "alarm=16384", kRunsOn,
       "motors are hot"},
      {kVirt, "WithoutRequired", "a function is missing: virtSetForce", "virtuose_without_required",
       "", kRefused, "virtSetForce"},
      {kVirt, "WithoutOptional", "functions that are not needed are missing",
       "virtuose_without_optional", "", kRunsOn},
      {kVirt, "Jitter", "servo comes 0.2 to 20 ms after the last time", "virtuose", "jitter=1",
       kRunsOn, "", GuardAct::kReadingLate},
      {kVirt, "NanPose", "a NaN in a pose", "virtuose", "nan_pose=300", kRunsOn, "",
       GuardAct::kReadingNotFinite},
      {kVirt, "Jump", "pose jumps by 50 mm", "virtuose", "jump=300", kRunsOn, "",
       GuardAct::kReadingJumped},
      {kVirt, "LongQuaternion", "quaternion of length 1.004", "virtuose", "long_quaternion=1.004",
       kRunsOn},
      {kVirt, "NoRotation", "quaternion of zeros", "virtuose", "no_rotation=300", kRunsOn, "",
       GuardAct::kReadingNotFinite},
  };
}

}  // namespace

const std::vector<VendorFault>& VendorFaults() {
  static const std::vector<VendorFault> faults = [] {
    std::vector<VendorFault> all = OpenHapticsFaults();
    for (const VendorFault& fault : ForceDimensionFaults()) all.push_back(fault);
    for (const VendorFault& fault : VirtuoseFaults()) all.push_back(fault);
    return all;
  }();
  return faults;
}

std::string VendorFaultTable() {
  std::string table = "| library | fault | outcome | the guard says | the user reads |\n";
  table += "|---|---|---|---|---|\n";
  for (const VendorFault& fault : VendorFaults()) {
    const std::string says = fault.says;
    table += std::string("| ") + Product(fault.driver) + " | " + fault.what + " | " +
             Words(fault.outcome) + " | " + (fault.act ? haptics::Words(*fault.act) : "") + " | " +
             (says.empty() ? "" : "\"" + says + "\"") + " |\n";
  }
  return table;
}

}  // namespace acus::testing_support
