// Stand-in for libdhd. Faults of its own:
//   time_guard=1             readings say that they came too soon
//   saturated=K              from K on forces are not all given
//   no_device=1 in_use=1 open_error=N enable_fails=1 stop_fails=1
//   force_off=K cause=C      the device switches its motors off at K; force_on=K: on again
//   status_error=K
#include <unistd.h>

#include "simulated_arm.h"

namespace {

using stand_in::Arm;
using stand_in::Matrix;
using stand_in::Pose;
using stand_in::Vector;
using stand_in::VendorAxes;

constexpr VendorAxes kAxes{{2, 0, 1}};  // Its x is to the user, y right, z up.

Pose pose{};
int last_error = 0;
bool force_is_off = false;

int Fail(int error) {
  last_error = error;
  return -1;
}

int Answer() {
  return Arm::Get().Fault("time_guard") != 0.0 ? 1 : 0;
}

int Open() {
  Arm& arm = Arm::Get();
  arm.Log("dhdOpen");
  while (arm.Fault("hang_open") != 0.0) sleep(1);
  if (arm.Fault("in_use") != 0.0) return Fail(20);
  if (arm.Fault("open_error") != 0.0) return Fail(static_cast<int>(arm.Fault("open_error")));
  force_is_off = false;
  return arm.Open() ? 3 : Fail(2);
}

int Push(const Vector& force_n, const Vector& torque_nm) {
  Arm::Get().Push(kAxes.ToOurs(force_n), kAxes.ToOurs(torque_nm));
  return Arm::Get().HasCome("saturated") ? 2 : Answer();
}

}  // namespace

ACUS_EXPORT int dhdGetDeviceCount() {
  return Arm::Get().Fault("no_device") != 0.0 ? 0 : 1;
}
ACUS_EXPORT int dhdOpenID(signed char) {
  return Open();
}
ACUS_EXPORT int dhdOpenSerial(int serial) {
  return serial == 815 ? Open() : Fail(5);
}
ACUS_EXPORT int dhdClose(signed char) {
  Arm::Get().Log("dhdClose");
  Arm::Get().Close();
  return 0;
}
ACUS_EXPORT int dhdStop(signed char) {
  Arm::Get().Log("dhdStop");
  Arm::Get().SwitchMotors(false);
  return Arm::Get().Fault("stop_fails") != 0.0 ? Fail(2) : 0;
}
ACUS_EXPORT int dhdGetSystemType(signed char) {
  return static_cast<int>(Arm::Get().Fault("type", 104));
}
ACUS_EXPORT int dhdGetSerialNumber(unsigned short* serial, signed char) {
  *serial = 815;
  return 0;
}
ACUS_EXPORT int dhdGetPosition(double* x, double* y, double* z, signed char id) {
  if (id != 3) return Fail(15);
  pose = Arm::Get().Read();
  if (Arm::Get().Fails()) return Fail(static_cast<int>(Arm::Get().Fault("error", 2)));
  const Vector place = kAxes.ToVendor(pose.place_m);
  *x = place[0];
  *y = place[1];
  *z = place[2];
  return Answer();
}
#ifdef ACUS_OLD_ROTATION
ACUS_EXPORT int dhdGetRotatorMatrix(double m[3][3], signed char) {
#else
ACUS_EXPORT int dhdGetOrientationFrame(double m[3][3], signed char) {
#endif
  const Matrix rotation = kAxes.ToVendor(pose.rotation);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) m[i][j] = rotation[i][j];
  }
  return Answer();
}
ACUS_EXPORT int dhdGetLinearVelocity(double* x, double* y, double* z, signed char) {
  const Vector velocity = kAxes.ToVendor(pose.velocity_m_s);
  *x = velocity[0];
  *y = velocity[1];
  *z = velocity[2];
  return Answer();
}
#ifndef ACUS_WITHOUT_OPTIONAL
ACUS_EXPORT int dhdGetAngularVelocityRad(double* x, double* y, double* z, signed char) {
  *x = *y = *z = 0.0;
  return Answer();
}
ACUS_EXPORT int dhdSetForceAndTorque(double fx, double fy, double fz, double tx, double ty,
                                     double tz, signed char) {
  return Push({fx, fy, fz}, {tx, ty, tz});
}
ACUS_EXPORT unsigned dhdGetButtonMask(signed char) {
  return Arm::Get().Buttons();
}
ACUS_EXPORT int dhdGetStatus(int status[17], signed char) {
  for (int i = 0; i < 17; ++i) status[i] = 0;
  const auto cause = static_cast<int>(Arm::Get().Fault("cause"));
  if (Arm::Get().HasCome("force_off") && !force_is_off) {
    force_is_off = true;
    Arm::Get().SwitchMotors(false);
  } else if (Arm::Get().HasCome("force_on")) {  // Somebody pressed the button again.
    Arm::Get().Set("force_on", 1e9);
    Arm::Get().SwitchMotors(true);
  }
  status[5] = Arm::Get().Value("motors_on") != 0.0 ? 1 : 0;
  if (status[5] == 0) status[14] = cause;
  status[9] = Arm::Get().HasCome("status_error") ? 1 : 0;
  return 0;
}
ACUS_EXPORT int dhdSetWatchdog(unsigned char, signed char) {
  Arm::Get().Log("dhdSetWatchdog");
  return 0;
}
#endif
ACUS_EXPORT int dhdSetForce(double x, double y, double z, signed char) {
  return Push({x, y, z}, {0, 0, 0});
}
ACUS_EXPORT int dhdGetButton(int index, signed char) {
  return static_cast<int>(Arm::Get().Buttons() >> index & 1U);
}
#ifndef ACUS_WITHOUT_REQUIRED
ACUS_EXPORT int dhdEnableForce(unsigned char on, signed char) {
  if (on != 0 && Arm::Get().Fault("enable_fails") != 0.0) return Fail(12);
  if (on == 0) Arm::Get().Log("motors off");
  Arm::Get().SwitchMotors(on != 0);
  return 0;
}
#endif
ACUS_EXPORT int dhdErrorGetLast() {
  return last_error;
}
