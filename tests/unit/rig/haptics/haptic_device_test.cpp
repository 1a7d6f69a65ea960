#include "acus/rig/haptics/haptic_device.h"

#include <atomic>
#include <chrono>
#include <gtest/gtest.h>
#include <memory>
#include <thread>

#include "acus/base/core/monotonic_time.h"
#include "acus/rig/haptics/driver.h"

namespace acus::haptics {
namespace {

/// Its ticks are those of the test.
struct TickedByHand final : Driver {
  DeviceInfo Open() override {
    DeviceInfo info;
    info.max_force_n = 10.0;
    return info;
  }
  void Run(GuardedServo& guarded) override { servo = &guarded; }
  void Halt() noexcept override {}
  void ZeroNow() noexcept override { ++num_zeros; }
  std::string FaultText(int) const override { return {}; }

  GuardedServo* servo = nullptr;
  static inline std::atomic<int> num_zeros{0};
};

DeviceForce HapticDevicePush(void*, const DeviceReading&) noexcept {
  return {.force_n = {2.0, 0.0, 0.0}, .torque_nmm = {}};
}

/// As if the thread lost its core just after it had looked at the clock, until the watchdog came.
std::int64_t TimeBeforeAPause() noexcept {
  const std::int64_t time_ns = MonotonicNs();
  const int before = TickedByHand::num_zeros;
  for (int n = 0; n < 10'000 && TickedByHand::num_zeros == before; ++n) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return time_ns;
}

TEST(HapticDevice, AStepThatIsCutAfterItsForceWasFoundGivesNone) {
  auto owned = std::make_unique<TickedByHand>();
  TickedByHand& driver = *owned;
  GuardSettings settings;
  settings.late_s = 0.1;  // A busy machine is not late.
  settings.settle_s = 0.01;
  settings.ramp_in_s = 0.05;
  HapticDevice device(std::move(owned), settings);
  device.Start({.tick = &HapticDevicePush, .context = nullptr});
  const auto tick = [&](std::int64_t (*clock)() noexcept) {
    DeviceReading reading;
    reading.time_ns = MonotonicNs();
    reading.valid = true;
    return driver.servo->Tick(reading, clock).force_n.norm();
  };
  double force_n = 0.0;
  for (int n = 0; n < 20'000 && force_n < 1.9; ++n) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    force_n = tick(&MonotonicNs);
  }
  ASSERT_GE(force_n, 1.9);
  EXPECT_EQ(tick(&TimeBeforeAPause), 0.0);
  EXPECT_EQ(tick(&MonotonicNs), 0.0);
  EXPECT_EQ(device.status().num_overruns, 1);
  device.Stop();
}

}  // namespace
}  // namespace acus::haptics
