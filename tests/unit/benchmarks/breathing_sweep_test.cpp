#include "benchmarks/breathing_sweep.h"

#include <gtest/gtest.h>
#include <map>
#include <tuple>

#include "benchmarks/breathing_body.h"

namespace acus::benchmarks {
namespace {

using Eigen::Vector3d;

TEST(BreathingBody, IsAtRestAtInspirationAndRisesAtExpiration) {
  const Vector3d dome(40.0, 20.0, 0.0);
  EXPECT_EQ(BreathingBody::DisplacementMm(BreathingBody::BreathAt(0.0), dome), Vector3d::Zero());
  const Vector3d out = BreathingBody::DisplacementMm(BreathingBody::BreathAt(0.5), dome);
  EXPECT_GT(out.z(), 14.0);
  EXPECT_LT(out.z(), BreathingBody::kSlidingMm);
  // Hysteresis: another way back, at the same level.
  const auto down = BreathingBody::BreathAt(0.2);
  const auto up = BreathingBody::BreathAt(0.8);
  EXPECT_NEAR(down.level, up.level, 1e-12);
  EXPECT_GT(
      (BreathingBody::DisplacementMm(down, dome) - BreathingBody::DisplacementMm(up, dome)).norm(),
      2.0);
}

TEST(BreathingBody, TheRateIsTheDerivativeOfTheLevel) {
  for (double cycle = 0.03; cycle < 1.0; cycle += 0.1) {
    const double step = 1e-5;
    const double slope = (BreathingBody::BreathAt(cycle + step).level -
                          BreathingBody::BreathAt(cycle - step).level) /
                         (2.0 * step * BreathingBody::kPeriodS);
    EXPECT_NEAR(BreathingBody::BreathAt(cycle).level_per_s, slope, 1e-6);
  }
}

// Across the wall the displacement jumps, but only along it: no gap opens.
TEST(BreathingBody, SlidesAlongItsWall) {
  const auto breath = BreathingBody::BreathAt(0.45);
  for (double angle = 0.0; angle < 6.2; angle += 0.4) {
    const Vector3d wall(150.0 * std::cos(angle), 100.0 * std::sin(angle), 5.0);
    const Vector3d jump = BreathingBody::DisplacementMm(breath, 0.9999 * wall) -
                          BreathingBody::DisplacementMm(breath, 1.0001 * wall);
    EXPECT_GT(jump.z(), 8.0);
    EXPECT_LT(std::hypot(jump.x(), jump.y()), 1e-3);
  }
}

TEST(BreathingSweep, ErrorsFallWithEveryKnobAndModelsDifferAsTheyShould) {
  std::map<std::tuple<std::string, std::string, std::string>, double> error;
  std::map<std::string, int> defaults;
  for (const Row& row : BreathingSweep().run(true, {})) {
    EXPECT_EQ(row.unusable, "");
    EXPECT_GE(row.error, 0.0);
    EXPECT_GT(row.step_us_median, 0.0);
    error[{row.knob, row.value, row.error_unit.substr(0, 8)}] = row.error;
    defaults[row.knob] += row.is_default;
  }
  for (const char* knob : {"field_nodes", "key_frames", "model", "haptic_iterations",
                           "pixel_iterations", "knot_spacing_mm"}) {
    EXPECT_GE(defaults[knob], 1) << knob;
  }
  const auto at = [&](const char* knob, const char* value, const char* unit) {
    return error.at({knob, value, unit});
  };
  // Trilinear: with the square of the spacing; at the wall, where it jumps, only with the spacing.
  EXPECT_LT(at("field_nodes", "32", "mm, more"), 0.3 * at("field_nodes", "16", "mm, more"));
  EXPECT_GT(at("field_nodes", "32", "mm, mean"), 0.4 * at("field_nodes", "16", "mm, mean"));
  EXPECT_LT(at("key_frames", "10", "mm, more"), 0.4 * at("key_frames", "4", "mm, more"));
  EXPECT_LT(at("haptic_iterations", "4", "mm, of t"), at("haptic_iterations", "1", "mm, of t"));
  EXPECT_LT(at("haptic_iterations", "1", "mm, of t"), 0.05);
  EXPECT_LT(at("pixel_iterations", "5", "mm, of a"), 0.01);
  EXPECT_GT(at("pixel_iterations", "0", "mm, of a"), 5.0);
  EXPECT_GT(at("pixel_iterations, from nothing", "1", "mm, of a"),
            10.0 * at("pixel_iterations", "1", "mm, of a"));
  // What the paper says of the models: the full cycle knows no deeper breath, the half cycle and
  // the sinusoid no hysteresis, the surrogate both.
  EXPECT_LT(at("model", "surrogate", "mm, brea"), 0.5 * at("model", "full_cycle", "mm, brea"));
  EXPECT_LT(at("model", "full_cycle", "mm, more"), 0.5 * at("model", "half_cycle", "mm, more"));
  EXPECT_LT(at("model", "surrogate", "mm, more"), 0.5 * at("model", "sinusoid", "mm, more"));
}

}  // namespace
}  // namespace acus::benchmarks
