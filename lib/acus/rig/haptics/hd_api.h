// The C interface of OpenHaptics (libHD) as function pointers. Facts only; no header of the vendor.
#pragma once

#include <string>

#include "acus/base/core/shared_library.h"

namespace acus::haptics::hd {

/// Returned by value: three words.
struct ErrorInfo {
  unsigned code;
  int internal_code;
  unsigned device;
};
using Callback = unsigned (*)(void* context);

inline constexpr unsigned kDone = 0;
inline constexpr unsigned kContinue = 1;
inline constexpr unsigned kNoDevice = 0xFFFFFFFF;
inline constexpr unsigned short kMostPriority = 65535;

enum Parameter : unsigned {
  kCurrentButtons = 0x2000,
  kCurrentVelocity = 0x2051,         ///< 3, mm/s.
  kCurrentTransform = 0x2052,        ///< 16, by columns, mm.
  kCurrentAngularVelocity = 0x2053,  ///< 3, rad/s.
  kDeviceModel = 0x2501,
  kSerialNumber = 0x2504,
  kUsableWorkspace = 0x2551,  ///< 6: lowest x y z, highest x y z, mm.
  kOutputDof = 0x2554,
  kMaxForce = 0x2603,       ///< N.
  kCurrentForce = 0x2700,   ///< 3, N.
  kCurrentTorque = 0x2701,  ///< 3, N mm.
};
enum Capability : unsigned {
  kForceOutput = 0x4000,
  kForceClamping = 0x4001,
  kForceRamping = 0x4002,
  kSoftwareForceLimit = 0x4003,
};
enum Calibration : unsigned { kCalibrated = 0x5000, kNeedsUpdate = 0x5001, kNeedsHand = 0x5002 };
inline constexpr unsigned kInkwellStyle = 4;
enum Error : unsigned {
  kSuccess = 0,
  kInvalidEnum = 0x100,
  kInvalidInputType = 0x103,
  kWarmMotors = 0x200,
  kForceError = 0x204,
  kDeviceFault = 0x300,
  kAlreadyInitiated = 0x301,
  kCommError = 0x302,
  kTimerError = 0x304,
  kFrameError = 0x402,
  kInvalidLicense = 0x600,
};

struct Api {
  unsigned (*InitDevice)(const char*) = nullptr;
  void (*DisableDevice)(unsigned) = nullptr;
  void (*MakeCurrentDevice)(unsigned) = nullptr;
  unsigned (*GetCurrentDevice)() = nullptr;
  void (*BeginFrame)(unsigned) = nullptr;
  void (*EndFrame)(unsigned) = nullptr;
  ErrorInfo (*GetError)() = nullptr;
  const char* (*GetErrorString)(unsigned) = nullptr;
  void (*Enable)(unsigned) = nullptr;
  void (*Disable)(unsigned) = nullptr;
  void (*GetIntegerv)(unsigned, int*) = nullptr;
  void (*GetDoublev)(unsigned, double*) = nullptr;
  const char* (*GetString)(unsigned) = nullptr;
  void (*SetDoublev)(unsigned, const double*) = nullptr;
  unsigned (*CheckCalibration)() = nullptr;
  unsigned (*CheckCalibrationStyle)() = nullptr;  ///< May be null.
  void (*UpdateCalibration)(unsigned) = nullptr;
  void (*StartScheduler)() = nullptr;
  void (*StopScheduler)() = nullptr;
  void (*SetSchedulerRate)(unsigned long) = nullptr;  ///< May be null.
  unsigned long (*ScheduleAsynchronous)(Callback, void*, unsigned short) = nullptr;
  void (*Unschedule)(unsigned long) = nullptr;
};

/// What is loaded, and where it is looked for.  @param library  the user's choice; may be empty.
LibraryRequest Library(const std::string& library, double timeout_s);

/// @param library  the user's choice; empty: libHD.so.  @throws InputError
Api Load(const std::string& library, double timeout_s);

}  // namespace acus::haptics::hd
