#include "acus/rig/haptics/force_guard.h"

#include <bit>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::haptics {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::int64_t kMs = 1'000'000;

GuardSettings Quick() {
  GuardSettings settings;
  settings.ramp_in_s = 0.0;
  settings.settle_s = 0.0;
  settings.force_slew_n_per_s = 1e5;
  settings.torque_slew_nmm_per_s = 1e7;
  return settings;
}

DeviceReading At(std::int64_t time_ns, const Vector3d& place_mm = Vector3d::Zero()) {
  DeviceReading reading;
  reading.time_ns = time_ns;
  reading.device_from_handle.translation() = place_mm;
  reading.valid = true;
  return reading;
}

DeviceForce Push(double x_n, double x_nmm = 0.0) {
  return {.force_n = Vector3d(x_n, 0.0, 0.0), .torque_nmm = Vector3d(x_nmm, 0.0, 0.0)};
}

/// A guard and its clock, at 1 kHz.
struct Loop {
  explicit Loop(const GuardSettings& settings) : guard(settings) {}

  DeviceForce Tick(const DeviceForce& wanted) {
    time_ns += kMs;
    return Tick(At(time_ns), wanted);
  }
  DeviceForce Tick(const DeviceReading& reading, const DeviceForce& wanted) {
    admitted = guard.Admit(reading, conditions);
    return guard.Limit(wanted, reading.time_ns);
  }

  ForceGuard guard;
  GuardConditions conditions;
  DeviceReading admitted;
  std::int64_t time_ns = 0;
};

TEST(ForceGuard, PassesWhatIsWithinTheLimits) {
  Loop loop(Quick());
  loop.Tick(Push(0.0));
  const DeviceForce force = loop.Tick(Push(2.5, -80.0));
  EXPECT_EQ(force.force_n, Vector3d(2.5, 0, 0));
  EXPECT_EQ(force.torque_nmm, Vector3d(-80.0, 0, 0));
  EXPECT_EQ(loop.guard.counts().now, 0U);
  EXPECT_EQ(loop.guard.counts().ticks, 2);
}

TEST(ForceGuard, CutsTheMagnitudeAndKeepsTheDirection) {
  Loop loop(Quick());
  loop.Tick({});
  const DeviceForce force = loop.Tick({.force_n = {30, 0, 40}, .torque_nmm = {0, 600, 800}});
  EXPECT_LT((force.force_n - Vector3d(1.8, 0, 2.4)).norm(), 1e-12);
  EXPECT_LT((force.torque_nmm - Vector3d(0, 60, 80)).norm(), 1e-12);
  EXPECT_EQ(loop.guard.counts()[GuardAct::kForceMagnitude], 1);
  EXPECT_EQ(loop.guard.counts()[GuardAct::kTorqueMagnitude], 1);
}

/// An arm that bears 0.88 N for ever, 3.3 N for a moment.
GuardSettings Warming() {
  GuardSettings settings = Quick();
  settings.max_force_n = 3.3;
  settings.continuous_force_n = 0.88;
  settings.continuous_over_s = 30.0;
  return settings;
}

TEST(ForceGuard, CutsAForceToTheContinuousLimitAsTheMotorsWarm) {
  const GuardSettings settings = Warming();
  Loop loop(settings);
  loop.Tick({});
  const double square = 0.88 * 0.88;
  // A force of 2 N may last until its mean square is 0.64 of the limit's: 4 (1 - exp(-t / 30 s)).
  const double first_cut_s = -30.0 * std::log(1.0 - 0.64 * square / 4.0);
  int cut_at = 0;
  double mean = 0.0;
  DeviceForce force;
  for (int ms = 1; ms <= 600'000; ++ms) {
    force = loop.Tick(Push(2.0));
    mean += -std::expm1(-1e-3 / 30.0) * (force.force_n.squaredNorm() - mean);
    ASSERT_LE(mean, square * (1.0 + 1e-12)) << ms;
    if (cut_at == 0 && force.force_n.x() < 2.0) cut_at = ms;
  }
  // Below the peak of 3.3 N, 2 N are cut later than the limit begins to fall.
  EXPECT_GT(1e-3 * cut_at, first_cut_s);
  EXPECT_LT(1e-3 * cut_at, 1.5 * first_cut_s);
  EXPECT_NEAR(force.force_n.x(), 0.88, 1e-3) << "for ever";
  EXPECT_GT(loop.guard.counts()[GuardAct::kForceContinuous], 500'000);
  EXPECT_EQ(loop.guard.counts()[GuardAct::kForceMagnitude], 0);
}

TEST(ForceGuard, MotorsCoolInRestAndNotByARestart) {
  Loop loop(Warming());
  loop.Tick({});
  for (int ms = 0; ms < 120'000; ++ms) loop.Tick(Push(3.0, 5.0));
  const double warm_n = loop.Tick(Push(3.0)).force_n.x();
  EXPECT_LT(warm_n, 1.0);
  loop.guard.Restart();
  loop.Tick({});
  EXPECT_NEAR(loop.Tick(Push(3.0)).force_n.x(), warm_n, 0.01);
  for (int ms = 0; ms < 60'000; ++ms) loop.Tick({});
  EXPECT_EQ(loop.Tick(Push(3.0)).force_n.x(), 3.0) << "cool again";
}

TEST(ForceGuard, AContinuousLimitAboveThePeakChangesNothing) {
  GuardSettings settings = Quick();
  settings.continuous_force_n = settings.max_force_n;
  Loop loop(settings);
  loop.Tick({});
  for (int ms = 0; ms < 100'000; ++ms) ASSERT_EQ(loop.Tick(Push(2.9)).force_n.x(), 2.9);
  EXPECT_EQ(loop.guard.counts()[GuardAct::kForceContinuous], 0);
}

TEST(ForceGuard, ForcesGrowByTheSlewLimitAndVanishAtOnce) {
  GuardSettings settings = Quick();
  settings.force_slew_n_per_s = 500.0;
  Loop loop(settings);
  loop.Tick({});
  for (int i = 1; i <= 5; ++i) {
    EXPECT_NEAR(loop.Tick(Push(2.4)).force_n.x(), std::min(0.5 * i, 2.4), 1e-12);
  }
  EXPECT_EQ(loop.guard.counts()[GuardAct::kForceSlew], 4);
  EXPECT_EQ(loop.Tick(Push(0.1)).force_n.x(), 0.1);  // A membrane that breaks is felt as that.
  loop.Tick(Push(0.6));
  // Turning round means going through nothing: only the new direction is slowed.
  EXPECT_NEAR(loop.Tick(Push(-3.0)).force_n.x(), -0.5, 1e-12);
}

TEST(ForceGuard, TurningAForceIsSlowedAcrossOnly) {
  GuardSettings settings = Quick();
  settings.force_slew_n_per_s = 500.0;
  Loop loop(settings);
  loop.Tick({});
  for (int i = 0; i < 4; ++i) loop.Tick(Push(2.0));
  // From (2, 0) to (1, 2): the nearest point of the way to nothing is (1, 0).
  const Vector3d force_n = loop.Tick({.force_n = {1, 2, 0}, .torque_nmm = {0, 0, 0}}).force_n;
  EXPECT_LT((force_n - Vector3d(1.0, 0.5, 0.0)).norm(), 1e-12);
}

TEST(ForceGuard, RampsInAfterTheStartAndSettles) {
  GuardSettings settings = Quick();
  settings.ramp_in_s = 0.1;
  settings.settle_s = 0.05;
  Loop loop(settings);
  for (int ms = 0; ms <= 200; ++ms) {
    const double expected_n = 2.0 * std::clamp((ms - 50) / 100.0, 0.0, 1.0);
    ASSERT_NEAR(loop.Tick(Push(2.0)).force_n.x(), expected_n, 1e-12) << ms;
  }
  EXPECT_EQ(loop.guard.counts()[GuardAct::kRampIn], 150);
}

TEST(ForceGuard, TheRampIsOfTheLimitedForce) {
  GuardSettings settings = Quick();
  settings.ramp_in_s = 0.1;
  Loop loop(settings);
  for (int ms = 0; ms <= 10; ++ms) loop.Tick(Push(1e9));
  EXPECT_NEAR(loop.Tick(Push(1e9)).force_n.x(), 3.0 * 0.11, 1e-9);
}

/// A fault: what makes it, and what is counted.
struct FaultCase {
  GuardAct act;
  std::function<DeviceForce(Loop&)> make;
};

TEST(ForceGuard, EveryFaultGivesZeroAtOnceAndRampsInAgain) {
  GuardSettings settings = Quick();
  settings.ramp_in_s = 0.1;
  settings.settle_s = 0.02;
  const auto with_reading = [](auto change) {
    return [change](Loop& loop) {
      loop.time_ns += kMs;
      DeviceReading reading = At(loop.time_ns);
      change(reading);
      return loop.Tick(reading, Push(2.0));
    };
  };
  const std::vector<FaultCase> cases = {
      {GuardAct::kReadingInvalid, with_reading([](DeviceReading& r) { r.valid = false; })},
      {GuardAct::kReadingNotFinite,
       with_reading([](DeviceReading& r) { r.device_from_handle.translation().y() = kNan; })},
      {GuardAct::kReadingNotFinite,
       with_reading([](DeviceReading& r) { r.device_from_handle.translation().z() = kInf; })},
      {GuardAct::kReadingNotFinite,
       with_reading([](DeviceReading& r) { r.velocity_mm_s.x() = kNan; })},
      {GuardAct::kReadingNotFinite,
       with_reading([](DeviceReading& r) { r.angular_velocity_rad_s.x() = -kInf; })},
      {GuardAct::kReadingNotFinite,
       with_reading([](DeviceReading& r) { r.device_from_handle.linear() *= 1.01; })},
      {GuardAct::kReadingNotFinite,
       with_reading([](DeviceReading& r) { r.device_from_handle.linear()(2, 2) = -1.0; })},
      {GuardAct::kReadingJumped,
       with_reading([](DeviceReading& r) { r.device_from_handle.translation().x() = 50.0; })},
      {GuardAct::kReadingJumped, with_reading([](DeviceReading& r) {
         r.device_from_handle.rotate(Eigen::AngleAxisd(1.0, Vector3d::UnitY()));
       })},
      {GuardAct::kTimeBack, with_reading([](DeviceReading& r) { r.time_ns -= kMs; })},
      {GuardAct::kReadingLate,
       [](Loop& loop) {
         loop.time_ns += 11 * kMs;
         return loop.Tick(At(loop.time_ns), Push(2.0));
       }},
      {GuardAct::kStepLate,
       [](Loop& loop) {
         loop.time_ns += kMs;
         loop.guard.Admit(At(loop.time_ns), {});
         return loop.guard.Limit(Push(2.0), loop.time_ns + 11 * kMs);
       }},
      {GuardAct::kMotorsOff, with_reading([](DeviceReading& r) { r.motors_on = false; })},
      {GuardAct::kForceNotFinite, [](Loop& loop) { return loop.Tick(Push(kNan)); }},
      {GuardAct::kForceNotFinite, [](Loop& loop) { return loop.Tick(Push(2.0, kInf)); }},
      {GuardAct::kInhibited,
       [](Loop& loop) {
         loop.conditions.inhibited = true;
         const DeviceForce force = loop.Tick(Push(2.0));
         loop.conditions.inhibited = false;
         return force;
       }},
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    Loop loop(settings);
    for (int ms = 0; ms < 200; ++ms) loop.Tick(Push(2.0));
    ASSERT_EQ(loop.Tick(Push(2.0)).force_n.x(), 2.0);
    const DeviceForce force = cases[i].make(loop);
    EXPECT_EQ(force.force_n, Vector3d::Zero()) << "case " << i;
    EXPECT_EQ(force.torque_nmm, Vector3d::Zero()) << "case " << i;
    EXPECT_EQ(loop.guard.counts()[cases[i].act], 1) << "case " << i;
    EXPECT_TRUE(loop.guard.counts().IsActing(cases[i].act)) << "case " << i;
    // A jump, and a time that comes back, are faults of two readings.
    int ms = 0;
    while (loop.Tick(Push(2.0)).force_n.x() == 0.0) ASSERT_LT(++ms, 100) << "case " << i;
    EXPECT_GE(ms, 20) << "case " << i;
    EXPECT_LE(ms, 22) << "case " << i;
    for (int rest = 0; rest < 105; ++rest) loop.Tick(Push(2.0));
    EXPECT_EQ(loop.Tick(Push(2.0)).force_n.x(), 2.0) << "case " << i;
  }
}

TEST(ForceGuard, WhatTheServoSeesIsTheLastGoodPoseUntilReadingsHaveSettled) {
  GuardSettings settings = Quick();
  settings.settle_s = 0.005;
  Loop loop(settings);
  loop.Tick({});
  EXPECT_TRUE(loop.admitted.valid);
  loop.time_ns += kMs;
  loop.Tick(At(loop.time_ns, Vector3d(1, 2, 3)), {});
  EXPECT_TRUE(loop.admitted.valid);
  for (int ms = 0; ms < 5; ++ms) {  // 50 mm away, and it stays there.
    loop.time_ns += kMs;
    loop.Tick(At(loop.time_ns, Vector3d(51, 2, 3)), {});
    EXPECT_FALSE(loop.admitted.valid) << ms;
    EXPECT_EQ(loop.admitted.device_from_handle.translation(), Vector3d(1, 2, 3)) << ms;
    EXPECT_EQ(loop.admitted.time_ns, loop.time_ns);
  }
  for (int ms = 0; ms < 2; ++ms) {
    loop.time_ns += kMs;
    loop.Tick(At(loop.time_ns, Vector3d(51, 2, 3)), {});
  }
  EXPECT_TRUE(loop.admitted.valid);
  EXPECT_EQ(loop.admitted.device_from_handle.translation(), Vector3d(51, 2, 3));
}

TEST(ForceGuard, ADeadManButtonMustBeHeldAndMustHaveBeenOpen) {
  GuardSettings settings = Quick();
  settings.dead_man = DeadMan::kButton;
  settings.dead_man_buttons = 0b110;
  Loop loop(settings);
  const auto tick = [&](unsigned buttons) {
    loop.time_ns += kMs;
    DeviceReading reading = At(loop.time_ns);
    reading.buttons = buttons;
    return loop.Tick(reading, Push(1.0)).force_n.x();
  };
  for (int i = 0; i < 10; ++i) EXPECT_EQ(tick(0b010), 0.0);  // Stuck: never seen open.
  EXPECT_EQ(tick(0b001), 0.0);                               // Another button.
  EXPECT_EQ(tick(0b010), 1.0);
  EXPECT_EQ(tick(0b100), 1.0);
  EXPECT_EQ(tick(0b000), 0.0);
  EXPECT_EQ(tick(0b100), 1.0);
  EXPECT_EQ(loop.guard.counts()[GuardAct::kDeadManOpen], 12);
  loop.guard.Restart();
  EXPECT_EQ(tick(0b100), 0.0);
}

TEST(ForceGuard, APedalDoesTheSame) {
  GuardSettings settings = Quick();
  settings.dead_man = DeadMan::kPedal;
  Loop loop(settings);
  loop.Tick(Push(1.0));
  loop.conditions.pedal_held = true;
  EXPECT_EQ(loop.Tick(Push(1.0)).force_n.x(), 1.0);
  loop.conditions.pedal_held = false;
  EXPECT_EQ(loop.Tick(Push(1.0)).force_n.x(), 0.0);
}

TEST(ForceGuard, SettingsThatMakeNoSenseAreRefused) {
  const auto refuses = [](auto change, const char* key) {
    GuardSettings settings;
    change(settings);
    EXPECT_THAT([&] { settings.Check("needle"); },
                ThrowsMessage<InputError>(testing::AllOf(HasSubstr("needle"), HasSubstr(key))));
  };
  EXPECT_NO_THROW(GuardSettings().Check("needle"));
  refuses([](GuardSettings& s) { s.max_force_n = -1.0; }, "max_force_n");
  refuses([](GuardSettings& s) { s.max_force_n = 41.0; }, "max_force_n");
  refuses([](GuardSettings& s) { s.max_torque_nmm = kNan; }, "max_torque_nmm");
  refuses([](GuardSettings& s) { s.force_slew_n_per_s = 0.0; }, "force_slew_n_per_s");
  refuses([](GuardSettings& s) { s.torque_slew_nmm_per_s = kInf; }, "torque_slew_nmm_per_s");
  refuses([](GuardSettings& s) { s.ramp_in_s = -0.1; }, "ramp_in_s");
  refuses([](GuardSettings& s) { s.settle_s = 11.0; }, "settle_s");
  refuses([](GuardSettings& s) { s.late_s = 0.0; }, "late_s");
  refuses([](GuardSettings& s) { s.jump_mm = 0.0; }, "jump_mm");
  refuses([](GuardSettings& s) { s.jump_rad = 4.0; }, "jump_rad");
  refuses(
      [](GuardSettings& s) {
        s.dead_man = DeadMan::kButton;
        s.dead_man_buttons = 0;
      },
      "dead-man");
}

TEST(ForceGuard, EveryActHasItsWords) {
  for (std::size_t i = 0; i < kNumGuardActs; ++i) {
    EXPECT_GT(std::string(Words(static_cast<GuardAct>(i))).size(), 10U) << i;
  }
}

/// Numbers of all sizes, and now and then what is no number.
double Anything(RandomStream& random) {
  const double kind = random.Uniform();
  if (kind < 0.002) return kNan;
  if (kind < 0.004) return random.Uniform() < 0.5 ? kInf : -kInf;
  if (kind < 0.006) return std::bit_cast<double>(random.Next());
  if (kind < 0.03) return random.Uniform(-1e308, 1e308);
  return random.Normal() * std::exp(random.Uniform(-8.0, 4.0));
}

Vector3d AnyVector(RandomStream& random) {
  return {Anything(random), Anything(random), Anything(random)};
}

struct FuzzedTick {
  DeviceReading reading;
  GuardConditions conditions;
  DeviceForce wanted;
  std::int64_t done_ns = 0;
};

FuzzedTick AnyTick(RandomStream& random, std::int64_t& time_ns) {
  FuzzedTick tick;
  const double kind = random.Uniform();
  time_ns += kind < 0.002 ? static_cast<std::int64_t>(random.Uniform(-5e7, 5e8))
                          : static_cast<std::int64_t>(random.Uniform(0.2e6, 2e6));
  tick.reading = At(time_ns);
  if (random.Uniform() < 0.0005) tick.reading.time_ns = static_cast<std::int64_t>(random.Next());
  if (random.Uniform() < 0.002) tick.reading.device_from_handle.translation() = AnyVector(random);
  if (random.Uniform() < 0.001) tick.reading.device_from_handle.linear()(1, 2) = Anything(random);
  if (random.Uniform() < 0.001) tick.reading.velocity_mm_s = AnyVector(random);
  tick.reading.valid = random.Uniform() > 0.001;
  tick.reading.motors_on = random.Uniform() > 0.001;
  tick.reading.buttons = static_cast<unsigned>(random.Uniform() > 0.001);
  tick.conditions.inhibited = random.Uniform() < 0.001;
  tick.wanted = {.force_n = AnyVector(random), .torque_nmm = AnyVector(random)};
  tick.done_ns = tick.reading.time_ns;
  if (random.Uniform() < 0.001) tick.done_ns = static_cast<std::int64_t>(random.Next());
  return tick;
}

/// The distance from `point` to the way from nothing to `last`.
double DistanceFromWay(const Vector3d& point, const Vector3d& last) {
  const double squared = last.squaredNorm();
  const double share = squared > 0.0 ? std::clamp(point.dot(last) / squared, 0.0, 1.0) : 0.0;
  return (point - share * last).norm();
}

TEST(ForceGuard, AMillionTicksOfInvalidDataNeverBreakALimit) {
  GuardSettings settings;
  settings.settle_s = 0.003;
  settings.ramp_in_s = 0.02;
  settings.dead_man = DeadMan::kButton;
  settings.continuous_force_n = 0.2;
  settings.continuous_over_s = 1.0;
  ForceGuard guard(settings);
  RandomStream random(11, "force guard");
  std::int64_t time_ns = 0;
  DeviceForce last;
  std::int64_t last_ns = 0;
  int num_pushing = 0;
  double mean_square = 0.0;
  for (int i = 0; i < 1'000'000; ++i) {
    const FuzzedTick tick = AnyTick(random, time_ns);
    const DeviceReading admitted = guard.Admit(tick.reading, tick.conditions);
    const DeviceForce force = guard.Limit(tick.wanted, tick.done_ns);
    ASSERT_TRUE(admitted.device_from_handle.matrix().allFinite()) << i;
    ASSERT_TRUE(force.force_n.allFinite() && force.torque_nmm.allFinite()) << i;
    ASSERT_LE(force.force_n.norm(), settings.max_force_n) << i;
    ASSERT_LE(force.torque_nmm.norm(), settings.max_torque_nmm) << i;
    const double since_s =
        1e-9 * (static_cast<double>(tick.reading.time_ns) - static_cast<double>(last_ns));
    const double dt_s = std::clamp(since_s, 0.0, settings.late_s) + 1e-6;  // Doubles of ns.
    ASSERT_LE(DistanceFromWay(force.force_n, last.force_n),
              settings.force_slew_n_per_s * dt_s + 1e-9)
        << i;
    ASSERT_LE(force.force_n.norm(), last.force_n.norm() + settings.force_slew_n_per_s * dt_s + 1e-9)
        << i;
    ASSERT_LE(DistanceFromWay(force.torque_nmm, last.torque_nmm),
              settings.torque_slew_nmm_per_s * dt_s + 1e-7)
        << i;
    const double share = -std::expm1(-std::clamp(since_s, 0.0, settings.late_s));
    mean_square += share * (force.force_n.squaredNorm() - mean_square);
    ASSERT_LE(mean_square, 0.04 * (1.0 + 1e-6)) << i;
    num_pushing += force.force_n.norm() > 0.1 ? 1 : 0;
    last = force;
    last_ns = tick.reading.time_ns;
  }
  const GuardCounts counts = guard.counts();
  EXPECT_GT(num_pushing, 100'000);  // It is not safe by doing nothing.
  for (std::size_t i = 0; i < kNumGuardActs; ++i) {
    EXPECT_GT(counts.of[i], 50) << Words(static_cast<GuardAct>(i));
  }
}

TEST(ForceGuard, GivesTheSameBitsAgain) {
  std::vector<DeviceForce> first;
  for (int run = 0; run < 2; ++run) {
    ForceGuard guard{GuardSettings()};
    RandomStream random(12, "force guard");
    std::int64_t time_ns = 0;
    for (std::size_t i = 0; i < 20'000; ++i) {
      const FuzzedTick tick = AnyTick(random, time_ns);
      guard.Admit(tick.reading, tick.conditions);
      const DeviceForce force = guard.Limit(tick.wanted, tick.done_ns);
      if (run == 0) first.push_back(force);
      ASSERT_TRUE(force.force_n == first[i].force_n && force.torque_nmm == first[i].torque_nmm);
    }
  }
}

}  // namespace
}  // namespace acus::haptics
