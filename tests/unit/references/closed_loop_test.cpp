#include "references/closed_loop.h"

#include <cmath>
#include <gmock/gmock.h>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::forces {
namespace {

using Eigen::Vector3d;

TEST(PassivityObserver, CountsWhatIsGivenBackBeyondWhatWasTaken) {
  PassivityObserver observer;
  observer.Add({0, 0, -2}, {0, 0, 3});  // Pushed in against 2 N: takes 6 mJ.
  EXPECT_NEAR(observer.taken_mj(), 6.0, 1e-12);
  observer.Add({0, 0, -2}, {0, 0, -4});  // Thrown out by 2 N over 4 mm: gives 8.
  EXPECT_NEAR(observer.generated_mj(), 2.0, 1e-12);
  observer.Add(Vector3d::Zero(), {0, 0, -1});  // Free: a new account.
  observer.Add({0, 0, -1}, {0, 0, -1});
  EXPECT_NEAR(observer.generated_mj(), 2.0, 1e-12);
  EXPECT_NEAR(observer.taken_mj(), -3.0, 1e-12);
}

// Mass, hand spring and all damping: an oscillator whose frequency and decay are known.
TEST(ClosedLoop, AFreeDeviceIsADampedOscillator) {
  HapticDevice device;
  device.mass_kg = 0.2;
  device.damping_n_s_per_m = 1.0;
  Hand hand;
  hand.stiffness_n_per_m = 500.0;
  hand.damping_n_s_per_m = 0.0;
  hand.wants_in_ct_mm = [](double t) { return Vector3d(t > 0.0 ? 10.0 : 0.0, 0, 0); };
  const LoopResult result = RunClosedLoop(
      device, hand, [](double, const Vector3d&) { return Vector3d::Zero().eval(); }, 0.5);
  const double decay = 1.0 / (2.0 * 0.2);
  const double omega = std::sqrt(500.0 / 0.2 - decay * decay);
  for (const LoopSample& s : result.samples) {
    const double expected_mm =
        10.0 - 10.0 * std::exp(-decay * s.time_s) *
                   (std::cos(omega * s.time_s) + decay / omega * std::sin(omega * s.time_s));
    ASSERT_NEAR(s.device_in_ct_mm.x(), expected_mm, 0.05) << s.time_s;
  }
  EXPECT_EQ(result.generated_mj, 0.0);
}

// A sampled spring gives, over a period of a motion of amplitude a and frequency w, pi K w tau a^2
// with tau = T (delay + 1/2): what the literature's b > K T / 2 is about.
TEST(ClosedLoop, ASampledSpringGivesTheEnergyOfTheory) {
  HapticDevice device;
  device.mass_kg = 0.1;
  device.encoder_mm = 0.0;
  device.delay_steps = 1;
  Hand hand;  // So stiff that it sets the motion.
  hand.stiffness_n_per_m = 1e6;
  hand.damping_n_s_per_m = 200.0;
  const double omega = 2.0 * std::numbers::pi * 5.0;
  hand.wants_in_ct_mm = [omega](double t) { return Vector3d(2.0 * std::sin(omega * t), 0, 0); };
  const LoopResult result = RunClosedLoop(
      device, hand, [](double, const Vector3d& x) { return Vector3d(-0.5 * x); }, 4.0);
  const double per_period = std::numbers::pi * 0.5 * omega * 0.0015 * 4.0;
  EXPECT_NEAR(-result.taken_mj, 20.0 * per_period, 0.05 * 20.0 * per_period);
}

TEST(ClosedLoop, ADamperTakesWhatItShould) {
  Hand hand;
  hand.stiffness_n_per_m = 1e6;
  hand.damping_n_s_per_m = 200.0;
  const double omega = 2.0 * std::numbers::pi * 2.0;
  hand.wants_in_ct_mm = [omega](double t) { return Vector3d(0, 3.0 * std::sin(omega * t), 0); };
  HapticDevice device;
  device.encoder_mm = 0.0;
  device.delay_steps = 0;
  Vector3d before = Vector3d::Zero();
  const LoopResult result = RunClosedLoop(
      device, hand,
      [&before](double, const Vector3d& x) {
        const Vector3d force = -0.002 * (x - before) / 0.001;
        before = x;
        return force;
      },
      2.0);
  EXPECT_NEAR(result.taken_mj, 0.002 * 0.5 * 9.0 * omega * omega * 2.0, 0.05 * 5.7);
  EXPECT_LT(result.generated_mj, 1e-3);
}

TEST(ClosedLoop, ChatterAndOscillationAreThoseOfTheForce) {
  LoopResult result;
  for (int i = 0; i < 4000; ++i) {
    LoopSample sample;
    sample.time_s = 0.001 * i;
    sample.force_n.z() = 1.0 + (i < 2000 ? 0.0 : 0.5 * ((i / 2) % 2 == 0 ? 1.0 : -1.0));  // 250 Hz.
    sample.device_in_ct_mm.y() = i < 2000 ? 0.0 : 0.1 * ((i / 2) % 2);
    result.samples.push_back(sample);
  }
  EXPECT_NEAR(result.ChatterN(0.5, 2.0), 0.0, 1e-9);
  EXPECT_NEAR(result.ChatterN(2.5, 4.0), 0.5, 0.05);
  EXPECT_EQ(result.SwingMm(0.0, 2.0), 0.0);
  EXPECT_NEAR(result.SwingMm(2.5, 4.0), 0.1, 1e-12);
}

TEST(ClosedLoop, TheRandomHandIsRepeatableAndStaysInItsRange) {
  const RandomHand settings;
  const auto a = RandomMotion(settings, 20.0, 4);
  const auto b = RandomMotion(settings, 20.0, 4);
  const auto other = RandomMotion(settings, 20.0, 5);
  double farthest = 0.0;
  double difference = 0.0;
  for (double t = 0.0; t < 20.0; t += 0.01) {
    EXPECT_EQ(a(t), b(t));
    EXPECT_GE(a(t).z(), -5.2);
    EXPECT_LE(a(t).z(), 40.2);
    farthest = std::max(farthest, a(t).head<2>().norm());
    difference = std::max(difference, (a(t) - other(t)).norm());
  }
  EXPECT_GT(farthest, 0.5);
  EXPECT_LT(farthest, 2.4);
  EXPECT_GT(difference, 5.0);
}

TEST(ClosedLoop, RefusesWhatCannotRun) {
  Hand hand;
  const ForceOfPlace free = [](double, const Vector3d&) { return Vector3d::Zero().eval(); };
  EXPECT_THROW(RunClosedLoop({}, hand, free, 1.0), InputError);
  hand.wants_in_ct_mm = [](double) { return Vector3d::Zero().eval(); };
  HapticDevice massless;
  massless.mass_kg = 0.0;
  EXPECT_THROW(RunClosedLoop(massless, hand, free, 1.0), InputError);
  EXPECT_THROW(RunClosedLoop({}, hand, free, 0.0), InputError);
}

}  // namespace
}  // namespace acus::forces
