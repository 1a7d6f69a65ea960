// What is called at each tick takes nothing from the heap.
#include <gtest/gtest.h>
#include <memory>

#include "acus/rig/haptics/haptic_device.h"
#include "acus/rig/haptics/virtual_hand_driver.h"
#include "support/allocation_counter.h"

namespace acus::haptics {
namespace {

TEST(Tick, TakesNothingFromTheHeapWhateverHappens) {
  const auto steering = std::make_shared<HandSteering>();
  VirtualHandSettings settings;
  Eigen::Isometry3d deep = Eigen::Isometry3d::Identity();
  deep.translation().x() = -20.0;
  settings.path.points = {{0.0, Eigen::Isometry3d::Identity()}, {0.5, deep}};
  auto driver =
      std::make_unique<VirtualHandDriver>(settings, steering, VirtualHandDriver::Clock::kStepped);
  VirtualHandDriver& hand = *driver;
  HapticDevice device(std::move(driver), GuardSettings());
  device.Start({.tick =
                    [](void*, const DeviceReading& reading) noexcept {
                      const double x_mm = reading.device_from_handle.translation().x();
                      DeviceForce force;
                      force.force_n.x() = x_mm < -15.0 ? std::nan("") : -x_mm;
                      return force;
                    },
                .context = nullptr});
  const long before = testing_support::num_allocations;
  std::int64_t time_ns = 0;
  for (int i = 0; i < 2000; ++i) {
    time_ns += i % 100 == 99 ? 50'000'000 : 1'000'000;  // Now and then late.
    if (i % 150 == 0) device.SetInhibited(Inhibit::kTrackerLost, i % 300 == 0);
    if (i == 1000) steering->Nudge({0, 200, 0}, {0, 1, 0});
    hand.Step(time_ns);
  }
  EXPECT_EQ(testing_support::num_allocations - before, 0);
  const GuardCounts counts = device.status().guard;
  EXPECT_GT(counts[GuardAct::kReadingLate], 10);
  EXPECT_GT(counts[GuardAct::kForceNotFinite], 10);
  EXPECT_GT(counts[GuardAct::kInhibited], 100);
  EXPECT_GT(counts[GuardAct::kRampIn], 50);
}

}  // namespace
}  // namespace acus::haptics
