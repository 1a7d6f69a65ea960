// The C interface of the Force Dimension SDK (libdhd) as function pointers. Facts only; no header
// of the vendor. m, m/s, N, N m, rad; `id` is a signed char, -1 for the current device.
#pragma once

#include <string>

#include "acus/base/core/shared_library.h"
#include "acus/rig/haptics/driver.h"

namespace acus::haptics::dhd {

using Id = signed char;

inline constexpr int kTimeGuard = 1;  ///< Called too soon; the data are valid.
inline constexpr int kMotorSaturated = 2;

enum Status : int {
  kStatusForce = 5,
  kStatusError = 9,
  kStatusForceOffCause = 14,
  kNumStatus = 17
};
enum Error : int {
  kErrorCom = 2,
  kErrorBusy = 3,
  kErrorNoDevice = 5,
  kErrorNotAvailable = 6,
  kErrorTimeout = 7,
  kErrorGeometry = 8,
  kErrorNotImplemented = 10,
  kErrorOutOfMemory = 11,
  kErrorRedundantFail = 18,
  kErrorInUse = 20,
};
/// Our own codes, for Report().
inline constexpr int kOwnSaturated = 1000;
inline constexpr int kOwnStatusError = 1001;
inline constexpr int kOwnForceOff = 1010;  ///< + cause 0 to 6.

struct Api {
  int (*GetDeviceCount)() = nullptr;
  int (*OpenId)(Id) = nullptr;
  int (*OpenSerial)(int) = nullptr;  ///< May be null.
  int (*Close)(Id) = nullptr;
  int (*Stop)(Id) = nullptr;
  const char* (*GetSystemName)(Id) = nullptr;  ///< May be null.
  int (*GetSystemType)(Id) = nullptr;
  int (*GetSerialNumber)(unsigned short*, Id) = nullptr;  ///< May be null.
  int (*GetPosition)(double*, double*, double*, Id) = nullptr;
  int (*GetOrientationFrame)(double (*)[3], Id) = nullptr;  ///< May be null.
  int (*GetLinearVelocity)(double*, double*, double*, Id) = nullptr;
  int (*GetAngularVelocityRad)(double*, double*, double*, Id) = nullptr;  ///< May be null.
  int (*SetForce)(double, double, double, Id) = nullptr;
  int (*SetForceAndTorque)(double, double, double, double, double, double, Id) = nullptr;  ///< Or.
  unsigned (*GetButtonMask)(Id) = nullptr;  ///< May be null: GetButton.
  int (*GetButton)(int, Id) = nullptr;
  int (*EnableForce)(unsigned char, Id) = nullptr;
  int (*SetGravityCompensation)(int, Id) = nullptr;  ///< May be null.
  int (*SetMaxForce)(double, Id) = nullptr;          ///< May be null.
  int (*SetWatchdog)(unsigned char, Id) = nullptr;   ///< May be null.
  int (*GetStatus)(int*, Id) = nullptr;              ///< May be null.
  int (*ErrorGetLast)() = nullptr;
  const char* (*ErrorGetLastStr)() = nullptr;  ///< May be null.
};

/// What is loaded, and where it is looked for.  @param library  the user's choice; may be empty.
LibraryRequest Library(const std::string& library, double timeout_s);

/// @param library  the user's choice; empty: libdhd.so.3, libdrd.so.3 and so on.
/// @throws InputError
Api Load(const std::string& library, double timeout_s);

DriverFault KindOf(int error) noexcept;
/// Plain words for an error of the vendor's or one of our own codes.
std::string Text(int error);

struct Model {
  const char* name;
  double max_force_n;
  double max_torque_nmm;  ///< 0: the wrist has no motors, or there is none.
  bool has_wrist;
};
/// By dhdGetSystemType. A type that is not known has the limits of the weakest.
Model ModelOf(int type) noexcept;

}  // namespace acus::haptics::dhd
