// The C interface of Haption's VirtuoseAPI, version 4, as function pointers. Facts only; no header
// of the vendor. Floats; m, N, N m; a pose is x y z qx qy qz qw.
#pragma once

#include <string>

#include "acus/base/core/shared_library.h"
#include "acus/rig/haptics/driver.h"

namespace acus::haptics::virtuose {

using Context = void*;
using Callback = void (*)(Context, void* argument);

inline constexpr int kImpedance = 3;   ///< Command type.
inline constexpr int kNoIndexing = 2;  ///< The pose does not shift while a button is held.
inline constexpr int kNumButtons = 3;

enum Error : int {
  kOutOfMemory = 1,
  kCommunicationFailure = 2,
  kInvalidContext = 3,
  kTimeOut = 6,
  kNotImplemented = 7,
  kNotAvailable = 8,
  kHardwareError = 11,
  kPositionDiscontinuity = 12,
  kMajorMinorVersion = 16,
  kWrongMode = 17,
  kModeNotSupported = 18,
  kIncompatibleVersion = 20,
};
enum Alarm : unsigned { kOverheat = 0x4000, kSaturate = 0x8000 };
/// Our own codes, for Report().
inline constexpr int kOwnEmergencyStop = 1000;
inline constexpr int kOwnDeadMan = 1001;
inline constexpr int kOwnOverheat = 1002;
inline constexpr int kOwnSaturated = 1003;
inline constexpr int kOwnPowerOff = 1004;

struct Api {
  Context (*Open)(const char*) = nullptr;
  int (*Close)(Context) = nullptr;
  int (*ApiVersion)(int*, int*) = nullptr;            ///< May be null.
  int (*GetDeviceId)(Context, int*, int*) = nullptr;  ///< May be null.
  int (*SetCommandType)(Context, int) = nullptr;
  int (*SetIndexingMode)(Context, int) = nullptr;
  int (*SetForceFactor)(Context, float) = nullptr;
  int (*SetSpeedFactor)(Context, float) = nullptr;
  int (*SetTimeStep)(Context, float) = nullptr;
  int (*SetBaseFrame)(Context, float*) = nullptr;
  int (*SetPowerOn)(Context, int) = nullptr;
  int (*GetEmergencyStop)(Context, int*) = nullptr;
  int (*GetDeadMan)(Context, int*) = nullptr;
  int (*GetButton)(Context, int, int*) = nullptr;
  int (*GetPosition)(Context, float*) = nullptr;
  int (*GetSpeed)(Context, float*) = nullptr;
  int (*SetForce)(Context, float*) = nullptr;
  int (*SetPeriodicFunction)(Context, Callback, float*, void*) = nullptr;
  int (*StartLoop)(Context) = nullptr;
  int (*StopLoop)(Context) = nullptr;
  int (*SaturateTorque)(Context, float, float) = nullptr;  ///< May be null.
  int (*GetAlarm)(Context, unsigned*) = nullptr;           ///< May be null.
  int (*SetTimeoutValue)(Context, float) = nullptr;        ///< May be null.
  int (*GetErrorCode)(Context) = nullptr;
};

/// What is loaded, and where it is looked for.  @param library  the user's choice; may be empty.
LibraryRequest Library(const std::string& library, double timeout_s);

/// @param library  the user's choice; empty: libVirtuoseAPI.so.
/// @throws InputError; says so if it is version 3, which has other functions.
Api Load(const std::string& library, double timeout_s);

DriverFault KindOf(int error) noexcept;
/// Plain words for an error of the vendor's or one of our own codes.
std::string Text(int error);

}  // namespace acus::haptics::virtuose
