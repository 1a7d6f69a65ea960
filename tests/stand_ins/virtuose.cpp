// Stand-in for libVirtuoseAPI. Faults of its own:
//   no_device=1 open_error=N    virtOpen gives no context
//   emergency_stop=1 dead_man_open=1   while they are set
//   alarm=BITS
//   long_quaternion=L           its length
//   power_fails=1 loop_fails=1 stop_fails=1
#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>
#include <unistd.h>

#include "simulated_arm.h"

namespace {

using stand_in::Arm;
using stand_in::Matrix;
using stand_in::Pose;
using stand_in::Vector;
using stand_in::VendorAxes;
using Context = void*;
using Callback = void (*)(Context, void*);

constexpr VendorAxes kAxes{{2, 0, 1}};  // Its x is to the user, y right, z up.

int here = 0;  // The context is a place in memory.
std::atomic<int> last_error{0};
Callback callback = nullptr;
void* callback_argument = nullptr;
std::thread& loop = *new std::thread;  // Outlives exit().
std::atomic<bool> loop_runs{false};
Pose pose{};

int Fail(int error) {
  last_error = error;
  return -1;
}

/// x y z w, of rotations by less than pi.
void ToQuaternion(const Matrix& m, float* q) {
  const double w = 0.5 * std::sqrt(std::max(0.0, 1.0 + m[0][0] + m[1][1] + m[2][2]));
  q[0] = static_cast<float>((m[2][1] - m[1][2]) / (4.0 * w));
  q[1] = static_cast<float>((m[0][2] - m[2][0]) / (4.0 * w));
  q[2] = static_cast<float>((m[1][0] - m[0][1]) / (4.0 * w));
  q[3] = static_cast<float>(w);
}

}  // namespace

ACUS_EXPORT Context virtOpen(const char* address) {
  Arm& arm = Arm::Get();
  arm.Log(std::string("virtOpen ") + address);
  while (arm.Fault("hang_open") != 0.0) sleep(1);
  if (arm.Fault("no_device") != 0.0) {
    last_error = static_cast<int>(arm.Fault("open_error", 2));
    return nullptr;
  }
  last_error = 2;
  return arm.Open() ? &here : nullptr;
}
ACUS_EXPORT int virtClose(Context) {
  Arm::Get().Log("virtClose");
  Arm::Get().Close();
  return 0;
}
ACUS_EXPORT int virtGetDeviceID(Context, int* type, int* serial) {
  *type = 1;
  *serial = 815;
  return 0;
}
ACUS_EXPORT int virtSetCommandType(Context, int type) {
  return type == 3 ? 0 : Fail(18);
}
ACUS_EXPORT int virtSetIndexingMode(Context, int) {
  return 0;
}
ACUS_EXPORT int virtSetForceFactor(Context, float) {
  return 0;
}
ACUS_EXPORT int virtSetSpeedFactor(Context, float) {
  return 0;
}
ACUS_EXPORT int virtSetTimeStep(Context, float) {
  return 0;
}
ACUS_EXPORT int virtSetBaseFrame(Context, float*) {
  return 0;
}
ACUS_EXPORT int virtSetPowerOn(Context, int on) {
  Arm::Get().Log(on != 0 ? "motors on" : "motors off");
  if (on != 0 && Arm::Get().Fault("power_fails") != 0.0) return Fail(11);
  Arm::Get().SwitchMotors(on != 0);
  return 0;
}
ACUS_EXPORT int virtGetEmergencyStop(Context, int* is_pressed) {
  *is_pressed = Arm::Get().Fault("emergency_stop") != 0.0 ? 1 : 0;
  if (*is_pressed != 0) Arm::Get().SwitchMotors(false);
  return 0;
}
ACUS_EXPORT int virtGetDeadMan(Context, int* is_held) {
  *is_held = Arm::Get().Fault("dead_man_open") != 0.0 ? 0 : 1;
  return 0;
}
ACUS_EXPORT int virtGetButton(Context, int index, int* is_held) {
  *is_held = static_cast<int>(Arm::Get().Buttons() >> index & 1U);
  return 0;
}
ACUS_EXPORT int virtGetPosition(Context, float* values) {
  pose = Arm::Get().Read();
  if (Arm::Get().Fails()) return Fail(static_cast<int>(Arm::Get().Fault("error", 2)));
  const Vector place = kAxes.ToVendor(pose.place_m);
  for (int i = 0; i < 3; ++i) values[i] = static_cast<float>(place[i]);
  ToQuaternion(kAxes.ToVendor(pose.rotation), values + 3);
  const auto length = static_cast<float>(
      Arm::Get().IsNow("no_rotation") ? 0.0 : Arm::Get().Fault("long_quaternion", 1.0));
  for (int i = 3; i < 7; ++i) values[i] *= length;
  return 0;
}
ACUS_EXPORT int virtGetSpeed(Context, float* values) {
  const Vector velocity = kAxes.ToVendor(pose.velocity_m_s);
  for (int i = 0; i < 3; ++i) values[i] = static_cast<float>(velocity[i]);
  for (int i = 3; i < 6; ++i) values[i] = 0.0F;
  return 0;
}
#ifndef ACUS_WITHOUT_REQUIRED
ACUS_EXPORT int virtSetForce(Context, float* f) {
  Arm::Get().Push(kAxes.ToOurs({f[0], f[1], f[2]}), kAxes.ToOurs({f[3], f[4], f[5]}));
  return 0;
}
#endif
ACUS_EXPORT int virtSetPeriodicFunction(Context, Callback function, float*, void* argument) {
  callback = function;
  callback_argument = argument;
  return 0;
}
ACUS_EXPORT int virtStartLoop(Context) {
  Arm::Get().Log("virtStartLoop");
  if (Arm::Get().Fault("loop_fails") != 0.0) return Fail(14);
  if (loop_runs.exchange(true)) return Fail(22);
  loop = std::thread([] {
    while (loop_runs) {
      if (!Arm::Get().HasCome("loop_dies")) callback(&here, callback_argument);
      std::this_thread::sleep_for(std::chrono::duration<double>(Arm::Get().SleepSeconds()));
    }
  });
  return 0;
}
ACUS_EXPORT int virtStopLoop(Context) {
  Arm::Get().Log("virtStopLoop");
  if (loop_runs.exchange(false)) loop.join();
  return Arm::Get().Fault("stop_fails") != 0.0 ? Fail(2) : 0;
}
#ifndef ACUS_WITHOUT_OPTIONAL
ACUS_EXPORT int virtSaturateTorque(Context, float, float) {
  return 0;
}
ACUS_EXPORT int virtGetAlarm(Context, unsigned* alarm) {
  *alarm = static_cast<unsigned>(Arm::Get().Fault("alarm"));
  return 0;
}
#endif
ACUS_EXPORT int virtGetErrorCode(Context) {
  return last_error;
}
