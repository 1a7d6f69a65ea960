// Stand-in for libHD. Faults of its own:
//   already_initiated=T   the first T calls of hdInitDevice say so
//   no_device=1 license=1 endless_errors=1 no_callback=1
//   calibration=1 (2: by hand)
//   disable_fails=1       hdDisableDevice leaves an error
#include <atomic>
#include <chrono>
#include <deque>
#include <thread>
#include <unistd.h>
#include <vector>

#include "simulated_arm.h"

namespace {

using stand_in::Arm;
using stand_in::Matrix;
using stand_in::Pose;
using stand_in::Vector;
using stand_in::VendorAxes;
using Callback = unsigned (*)(void*);

struct ErrorInfo {
  unsigned code;
  int internal_code;
  unsigned device;
};

constexpr VendorAxes kAxes{{0, 1, 2}};

std::mutex mutex;                                          // Of all below.
std::deque<unsigned>& errors = *new std::deque<unsigned>;  // As all below, outlives exit().
Pose pose{};
Vector force_n{};
Vector torque_nm{};
bool in_frame = false;
bool is_calibrated = false;
struct Scheduled {
  Callback callback;
  void* context;
  unsigned long handle;
};
std::vector<Scheduled>& callbacks = *new std::vector<Scheduled>;
unsigned num_devices = 0;                   ///< That are open; they share the arm.
std::thread& scheduler = *new std::thread;  // Outlives exit().
std::atomic<bool> scheduler_runs{false};

void Raise(unsigned code) {
  const std::lock_guard lock(mutex);
  errors.push_back(code);
}

void Unschedule(unsigned long handle) {
  const std::lock_guard lock(mutex);
  std::erase_if(callbacks, [=](const Scheduled& s) { return s.handle == handle; });
}

void Schedule() {
  while (scheduler_runs) {
    std::vector<Scheduled> due;
    {
      const std::lock_guard lock(mutex);
      due = callbacks;
    }
    for (const Scheduled& next : due) {
      if (!Arm::Get().HasCome("loop_dies") && next.callback(next.context) == 0) {
        Unschedule(next.handle);
      }
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(Arm::Get().SleepSeconds()));
  }
}

void Copy(const Vector& from, double scale, double* to) {
  for (int i = 0; i < 3; ++i) to[i] = scale * from[i];
}

}  // namespace

ACUS_EXPORT unsigned hdInitDevice(const char* name) {
  Arm& arm = Arm::Get();
  arm.Log("hdInitDevice");
  while (arm.Fault("hang_open") != 0.0) sleep(1);
  if (name == nullptr && arm.Fault("no_null_name") != 0.0) {
    Raise(0x300);
    return 0xFFFFFFFF;
  }
  const double left = arm.Fault("already_initiated");
  if (left > 0.0) {
    arm.Set("already_initiated", left - 1.0);
    Raise(0x301);
    return 0xFFFFFFFF;
  }
  if (arm.Fault("license") != 0.0) Raise(0x600);
  is_calibrated = arm.Fault("calibration") == 0.0;
  if (arm.Fault("no_device") != 0.0 || !arm.Open()) {
    Raise(0x300);
    return 0xFFFFFFFF;
  }
  return 7 + num_devices++;
}
ACUS_EXPORT void hdDisableDevice(unsigned) {
  Arm::Get().Log("hdDisableDevice");
  if (num_devices > 0 && --num_devices == 0) Arm::Get().Close();
  if (Arm::Get().Fault("disable_fails") != 0.0) Raise(0x302);
}
ACUS_EXPORT void hdMakeCurrentDevice(unsigned) {}
ACUS_EXPORT unsigned hdGetCurrentDevice() {
  return 7;
}
ACUS_EXPORT void hdBeginFrame(unsigned) {
  if (in_frame) Raise(0x400);
  in_frame = true;
  if (Arm::Get().Fails()) Raise(static_cast<unsigned>(Arm::Get().Fault("error", 0x302)));
  pose = Arm::Get().Read();
}
ACUS_EXPORT void hdEndFrame(unsigned) {
  if (!in_frame) Raise(0x401);
  in_frame = false;
  Arm::Get().Push(kAxes.ToOurs(force_n), kAxes.ToOurs(torque_nm));
}
ACUS_EXPORT ErrorInfo hdGetError() {
  const std::lock_guard lock(mutex);
  if (Arm::Get().Fault("endless_errors") != 0.0) return {0x302, -28, 7};
  if (errors.empty()) return {0, 0, 7};
  const unsigned code = errors.front();
  errors.pop_front();
  return {code, -28, 7};
}
#ifndef ACUS_WITHOUT_OPTIONAL
ACUS_EXPORT const char* hdGetErrorString(unsigned) {
  return "as the vendor words it";
}
ACUS_EXPORT const char* hdGetString(unsigned what) {
  return what == 0x2501 ? "Stand-in Touch" : "0815";
}
#endif
ACUS_EXPORT void hdEnable(unsigned what) {
  if (what == 0x4000) Arm::Get().SwitchMotors(true);
}
ACUS_EXPORT void hdDisable(unsigned what) {
  if (what != 0x4000) return;
  Arm::Get().Log("motors off");
  Arm::Get().SwitchMotors(false);
}
ACUS_EXPORT void hdGetIntegerv(unsigned what, int* value) {
  if (what == 0x2000) *value = static_cast<int>(Arm::Get().Buttons());
  if (what == 0x2554) *value = 6;
}
ACUS_EXPORT void hdGetDoublev(unsigned what, double* values) {
  switch (what) {
    case 0x2051:
      return Copy(kAxes.ToVendor(pose.velocity_m_s), 1e3, values);
    case 0x2052: {
      const Matrix rotation = kAxes.ToVendor(pose.rotation);
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) values[4 * column + row] = rotation[row][column];
        values[4 * row + 3] = 0.0;
      }
      Copy(kAxes.ToVendor(pose.place_m), 1e3, values + 12);
      values[15] = 1.0;
      return;
    }
    case 0x2053:
      return Copy({0, 0, 0}, 1.0, values);
    case 0x2551:
      for (int i = 0; i < 6; ++i) values[i] = i < 3 ? -100.0 : 100.0;
      return;
    case 0x2603:
      *values = 3.3;
      return;
    default:
      Raise(0x100);
  }
}
ACUS_EXPORT void hdSetDoublev(unsigned what, const double* values) {
  if (!in_frame) Raise(0x402);
  if (what == 0x2700) Copy({values[0], values[1], values[2]}, 1.0, force_n.data());
  if (what == 0x2701) Copy({values[0], values[1], values[2]}, 1e-3, torque_nm.data());
}
ACUS_EXPORT unsigned hdCheckCalibration() {
  if (is_calibrated) return 0x5000;
  return Arm::Get().Fault("calibration") > 1.0 ? 0x5002 : 0x5001;
}
ACUS_EXPORT unsigned hdCheckCalibrationStyle() {
  return 4;
}
ACUS_EXPORT void hdUpdateCalibration(unsigned) {
  Arm::Get().Log("hdUpdateCalibration");
  is_calibrated = true;
}
ACUS_EXPORT void hdStartScheduler() {
  Arm::Get().Log("hdStartScheduler");
  if (scheduler_runs.exchange(true)) return;
  scheduler = std::thread(Schedule);
}
ACUS_EXPORT void hdStopScheduler() {
  Arm::Get().Log("hdStopScheduler");
  if (scheduler_runs.exchange(false)) scheduler.join();
}
#ifndef ACUS_WITHOUT_REQUIRED
ACUS_EXPORT unsigned long hdScheduleAsynchronous(Callback function, void* context, unsigned short) {
  if (Arm::Get().Fault("no_callback") != 0.0) {
    Raise(0x501);
    return 0;
  }
  static unsigned long num_scheduled = 0;
  const std::lock_guard lock(mutex);
  callbacks.push_back({function, context, ++num_scheduled});
  return num_scheduled;
}
#endif
ACUS_EXPORT void hdUnschedule(unsigned long handle) {
  Arm::Get().Log("hdUnschedule");
  Unschedule(handle);
}
