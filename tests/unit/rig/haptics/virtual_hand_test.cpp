#include "acus/rig/haptics/virtual_hand.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <numbers>
#include <thread>

#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"
#include "acus/rig/haptics/haptic_device.h"
#include "acus/rig/haptics/virtual_hand_driver.h"

namespace acus::haptics {
namespace {

using Eigen::Vector3d;

Eigen::Isometry3d VirtualHandAt(const Vector3d& place_mm, double turn_rad = 0.0) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = place_mm;
  pose.linear() = Eigen::AngleAxisd(turn_rad, Vector3d::UnitY()).toRotationMatrix();
  return pose;
}

VirtualHandSettings Still() {
  VirtualHandSettings settings;
  settings.tremor_mm = 0.0;
  settings.encoder_mm = 0.0;
  return settings;
}

TEST(GoalPath, RestsAtWaypointsAndIsHalfwayInHalfTheTime) {
  GoalPath path;
  path.points = {{1.0, VirtualHandAt({0, 0, 0})},
                 {2.0, VirtualHandAt({10, 0, 0}, 1.0)},
                 {4.0, VirtualHandAt({10, 20, 0}, 1.0)}};
  EXPECT_EQ(path.At(0.0).translation(), Vector3d(0, 0, 0));
  EXPECT_LT((path.At(1.5).translation() - Vector3d(5, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(math::AngleBetweenRad(path.At(1.5), VirtualHandAt({0, 0, 0})), 0.5, 1e-12);
  EXPECT_LT((path.At(3.0).translation() - Vector3d(10, 10, 0)).norm(), 1e-12);
  EXPECT_EQ(path.At(9.0).translation(), Vector3d(10, 20, 0));
  // VirtualHandAt rest there: the third power of the time to it.
  EXPECT_LT(path.At(1.01).translation().x(), 1e-3);
  path.between = GoalPath::Between::kLinear;
  EXPECT_NEAR(path.At(1.25).translation().x(), 2.5, 1e-12);
  path.repeats = true;
  EXPECT_NEAR(path.At(4.25).translation().x(), 2.5, 1e-12);
  EXPECT_TRUE(GoalPath().At(1.0).isApprox(Eigen::Isometry3d::Identity()));
}

TEST(GoalPath, RefusesTimesThatDoNotIncreaseAndWhatIsNoPose) {
  GoalPath path;
  path.points = {{1.0, VirtualHandAt({0, 0, 0})}, {1.0, VirtualHandAt({0, 0, 0})}};
  EXPECT_THROW(path.Check(), InputError);
  path.points = {{std::nan(""), VirtualHandAt({0, 0, 0})}};
  EXPECT_THROW(path.Check(), InputError);
  path.points = {{1.0, VirtualHandAt({0, std::nan(""), 0})}};
  EXPECT_THROW(path.Check(), InputError);
}

TEST(VirtualHand, RefusesSettingsOutOfRange) {
  const auto refuses = [](auto change) {
    VirtualHandSettings settings;
    change(settings);
    EXPECT_THROW(settings.Check(), InputError);
  };
  EXPECT_NO_THROW(VirtualHandSettings().Check());
  refuses([](VirtualHandSettings& s) { s.mass_kg = 0.0; });
  refuses([](VirtualHandSettings& s) { s.mass_kg = 11.0; });
  refuses([](VirtualHandSettings& s) { s.damping_n_s_per_m = -1.0; });
  refuses([](VirtualHandSettings& s) { s.stiffness_n_per_m = std::nan(""); });
  refuses([](VirtualHandSettings& s) { s.inertia_kg_mm2 = 0.0; });
  refuses([](VirtualHandSettings& s) { s.tremor_mm = 6.0; });
  refuses([](VirtualHandSettings& s) { s.rate_hz = 0.0; });
}

// The ranges that the schema of a devices file states.
TEST(VirtualHand, AcceptsSettingsAtTheEndsOfTheirRanges) {
  const auto accepts = [](auto change) {
    VirtualHandSettings settings;
    change(settings);
    EXPECT_NO_THROW(settings.Check());
  };
  for (const double kg : {0.01, 10.0}) accepts([&](VirtualHandSettings& s) { s.mass_kg = kg; });
  for (const double n_s_per_m : {0.0, 1000.0}) {
    accepts([&](VirtualHandSettings& s) { s.damping_n_s_per_m = n_s_per_m; });
    accepts([&](VirtualHandSettings& s) { s.grip_damping_n_s_per_m = n_s_per_m; });
  }
  for (const double n_per_m : {1.0, 5000.0}) {
    accepts([&](VirtualHandSettings& s) { s.stiffness_n_per_m = n_per_m; });
  }
  for (const double kg_mm2 : {1.0, 1e5}) {
    accepts([&](VirtualHandSettings& s) { s.inertia_kg_mm2 = kg_mm2; });
  }
  for (const double mm : {0.0, 5.0}) accepts([&](VirtualHandSettings& s) { s.tremor_mm = mm; });
  for (const double hz : {100.0, 4000.0}) accepts([&](VirtualHandSettings& s) { s.rate_hz = hz; });
}

TEST(VirtualHand, YieldsToAForceByTheStiffnessOfItsGrip) {
  VirtualHand hand(Still(), nullptr);
  DeviceReading reading;
  for (int i = 0; i < 3000; ++i) {
    reading = hand.Step({.force_n = {2.0, 0, -1.0}, .torque_nmm = {0, 100.0, 0}}, 1e-3);
  }
  // 2 N against 400 N/m are 5 mm; 100 N mm against 2000 N mm/rad are 0.05 rad.
  EXPECT_LT((reading.device_from_handle.translation() - Vector3d(5.0, 0, -2.5)).norm(), 1e-6);
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(reading.device_from_handle.linear()));
  EXPECT_LT((turn.angle() * turn.axis() - Vector3d(0, 0.05, 0)).norm(), 1e-6);
  EXPECT_LT(reading.velocity_mm_s.norm(), 1e-6);
}

TEST(VirtualHand, OscillatesAsAMassOnASpring) {
  VirtualHandSettings settings = Still();
  settings.damping_n_s_per_m = 0.0;
  settings.grip_damping_n_s_per_m = 2.0;
  VirtualHand hand(settings, nullptr);
  // Let go from 5 mm: x = 5 exp(-d t) (cos w t + d/w sin w t).
  for (int i = 0; i < 5000; ++i) hand.Step({.force_n = {2.0, 0, 0}, .torque_nmm = {0, 0, 0}}, 1e-3);
  const double d = 2.0 / (2.0 * 0.15);
  const double w = std::sqrt(400.0 / 0.15 - d * d);
  double largest_mm = 0.0;
  for (int i = 1; i <= 300; ++i) {
    const double t = 1e-3 * i;
    const double expected_mm = 5.0 * std::exp(-d * t) * (std::cos(w * t) + d / w * std::sin(w * t));
    const DeviceReading reading = hand.Step({}, 1e-3);
    largest_mm =
        std::max(largest_mm, std::abs(reading.device_from_handle.translation().x() - expected_mm));
  }
  EXPECT_LT(largest_mm, 0.05);  // First order in its step of 0.1 ms.
}

TEST(VirtualHand, FollowsItsPathAndTrembles) {
  VirtualHandSettings settings;
  settings.path.points = {{0.0, VirtualHandAt({0, 0, 0})}, {2.0, VirtualHandAt({0, 0, -60}, 0.3)}};
  VirtualHand hand(settings, nullptr);
  double furthest_mm = 0.0;
  for (int i = 1; i <= 2500; ++i) {
    const DeviceReading reading = hand.Step({}, 1e-3);
    const Eigen::Isometry3d goal = settings.path.At(1e-3 * i);
    furthest_mm = std::max(furthest_mm,
                           (reading.device_from_handle.translation() - goal.translation()).norm());
    // In steps of the encoder.
    const double steps = reading.device_from_handle.translation().x() / 0.02;
    ASSERT_NEAR(steps, std::round(steps), 1e-6);
  }
  EXPECT_GT(furthest_mm, 0.1);  // Tremor.
  EXPECT_LT(furthest_mm, 1.0);
}

TEST(VirtualHand, IsSteeredFromOutsideAndGoesBackToItsPath) {
  VirtualHandSettings settings = Still();
  settings.path.points = {{0.0, VirtualHandAt({1, 2, 3})}};
  HandSteering steering;
  VirtualHand hand(settings, &steering);
  const auto settle = [&] {
    DeviceReading reading;
    for (int i = 0; i < 3000; ++i) reading = hand.Step({}, 1e-3);
    return reading;
  };
  EXPECT_LT((settle().device_from_handle.translation() - Vector3d(1, 2, 3)).norm(), 1e-6);
  EXPECT_EQ(steering.goal().translation(), Vector3d(1, 2, 3));
  EXPECT_FALSE(steering.is_steered());
  steering.Nudge({0.5, 0, 0}, {0, 0, 0.1});
  steering.Nudge({0.5, 0, 0}, {0, 0, 0.1});
  steering.SetButtons(0b10);
  const DeviceReading nudged = settle();
  EXPECT_TRUE(steering.is_steered());
  EXPECT_LT((nudged.device_from_handle.translation() - Vector3d(2, 2, 3)).norm(), 1e-6);
  EXPECT_NEAR(math::AngleBetweenRad(nudged.device_from_handle, VirtualHandAt({0, 0, 0})), 0.2,
              1e-6);
  EXPECT_EQ(nudged.buttons, 0b10U);
  steering.SetGoal(VirtualHandAt({-40, 0, 0}));
  EXPECT_LT((settle().device_from_handle.translation() - Vector3d(-40, 0, 0)).norm(), 1e-6);
  steering.SetGoal(VirtualHandAt({std::nan(""), 0, 0}));  // Not heeded.
  EXPECT_LT((settle().device_from_handle.translation() - Vector3d(-40, 0, 0)).norm(), 1e-6);
  steering.FollowPath();
  EXPECT_LT((settle().device_from_handle.translation() - Vector3d(1, 2, 3)).norm(), 1e-6);
}

TEST(VirtualHand, AGoalFarAwayIsReachedWithoutAJump) {
  HandSteering steering;
  VirtualHand hand(Still(), &steering);
  DeviceReading before = hand.Step({}, 1e-3);
  steering.SetGoal(VirtualHandAt({500, 0, 0}, 3.0));
  double longest_mm = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const DeviceReading reading = hand.Step({}, 1e-3);
    longest_mm = std::max(longest_mm, (reading.device_from_handle.translation() -
                                       before.device_from_handle.translation())
                                          .norm());
    ASSERT_LT(math::AngleBetweenRad(reading.device_from_handle, before.device_from_handle), 0.78);
    before = reading;
  }
  EXPECT_LT(longest_mm, GuardSettings().jump_mm / 2.0);
  EXPECT_NEAR(before.device_from_handle.translation().x(), 500.0, 1e-3);
}

TEST(VirtualHand, CorrectsWhatAForcePushesItOffUnlessItIsSteered) {
  const DeviceForce force{.force_n = {3.0, 0.0, 0.0}, .torque_nmm = Vector3d::Zero()};
  const auto place_x = [&force](double correction_s, HandSteering* steering) {
    VirtualHandSettings settings = Still();
    settings.correction_s = correction_s;
    VirtualHand hand(settings, steering);
    DeviceReading reading;
    for (int ms = 0; ms < 3000; ++ms) reading = hand.Step(force, 1e-3);
    return reading.device_from_handle.translation().x();
  };
  EXPECT_NEAR(place_x(0.0, nullptr), 7.5, 1e-3) << "3 N over 400 N/m";
  EXPECT_NEAR(place_x(0.3, nullptr), 0.0, 0.01);
  HandSteering steering;
  steering.SetGoal(Eigen::Isometry3d::Identity());
  EXPECT_NEAR(place_x(0.3, &steering), 7.5, 1e-3) << "the person corrects";
}

/// A wall at x = 0 of 1 N/mm, and a count of what it saw.
struct Wall {
  static DeviceForce Tick(void* me, const DeviceReading& reading) noexcept {
    auto& wall = *static_cast<Wall*>(me);
    ++wall.num_ticks;
    wall.last = reading;
    const double depth_mm = -reading.device_from_handle.translation().x();
    return {.force_n = {std::max(0.0, depth_mm), 0, 0}, .torque_nmm = {0, 0, 0}};
  }
  Servo servo() { return {.tick = &Wall::Tick, .context = this}; }
  std::atomic<int> num_ticks{0};
  DeviceReading last;
};

VirtualHandSettings IntoTheWall() {
  VirtualHandSettings settings;
  settings.path.points = {{0.0, VirtualHandAt({5, 0, 0})}, {1.0, VirtualHandAt({-5, 0, 0})}};
  return settings;
}

TEST(VirtualHandDriver, SteppedByItsOwnerGivesTheSameBits) {
  std::vector<Vector3d> first;
  for (int run = 0; run < 2; ++run) {
    Wall wall;
    auto driver = std::make_unique<VirtualHandDriver>(IntoTheWall(), nullptr,
                                                      VirtualHandDriver::Clock::kStepped);
    VirtualHandDriver& hand = *driver;
    HapticDevice device(std::move(driver), GuardSettings());
    hand.Step(5);  // Before the start: nothing.
    device.Start(wall.servo());
    for (std::size_t i = 0; i < 2000; ++i) {
      hand.Step(1'000'000 * static_cast<std::int64_t>(i));
      const Vector3d place_mm = wall.last.device_from_handle.translation();
      if (run == 0) first.push_back(place_mm);
      ASSERT_EQ(place_mm, first[i]);
    }
    EXPECT_EQ(wall.num_ticks, 2000);
    const DeviceStatus status = device.status();
    EXPECT_EQ(status.state, DeviceState::kRunning);
    EXPECT_EQ(status.ticks, 2000);
    // Grip and wall share the way: 400 / (400 + 1000) of 5 mm.
    EXPECT_NEAR(status.force.force_n.x(), 5.0 * 400.0 / 1400.0, 0.3);
    EXPECT_EQ(status.reading.device_from_handle.translation(), first.back());
    device.Stop();
    EXPECT_EQ(device.status().state, DeviceState::kStopped);
    hand.Step(1'000'000'000'000);
    EXPECT_EQ(wall.num_ticks, 2000);
  }
}

TEST(VirtualHandDriver, RunsOnItsOwnThreadAndMayBeStartedAgain) {
  Wall wall;
  HapticDevice device(std::make_unique<VirtualHandDriver>(IntoTheWall(), nullptr), GuardSettings());
  for (int run = 1; run <= 2; ++run) {
    const int before = wall.num_ticks;
    device.Start(wall.servo());
    EXPECT_THROW(device.Start(wall.servo()), InputError);
    while (wall.num_ticks < 100 * run) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    device.Stop();
    device.Stop();
    const int num_ticks = wall.num_ticks;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    EXPECT_EQ(wall.num_ticks, num_ticks);
    EXPECT_EQ(device.status().ticks, num_ticks - before) << "those since the start";
  }
}

}  // namespace
}  // namespace acus::haptics
