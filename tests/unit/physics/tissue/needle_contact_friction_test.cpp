// The 3D contact model: friction that depends on speed and on rest.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "support/fem_needle_scene.h"

namespace acus::tissue {
namespace {

using testing_support::FemScene;
using testing_support::SceneOptions;

constexpr forces::TissueTime kTimedShaft{
    .relaxation = {}, .friction_rate = 0.1, .friction_dwell = 0.08};

SceneOptions WithTimedShaft() {
  SceneOptions options;
  options.time = kTimedShaft;
  return options;
}

double ShareAt(double speed_mm_per_s, double age_s) {
  const forces::FrictionTime time;
  return forces::FrictionShare(kTimedShaft, {time.RateLog(speed_mm_per_s), time.DwellLog(age_s)});
}

TEST(NeedleContactFriction, GrowsWithTheLogarithmOfSpeed) {
  for (const double speed_mm_per_s : {2.0, 5.0, 50.0}) {
    SceneOptions as_much;  // The friction that the law gives at this speed, for good.
    as_much.friction = ShareAt(speed_mm_per_s, 1.0 / speed_mm_per_s);
    FemScene plain(as_much), timed(WithTimedShaft());
    plain.step_s = timed.step_s = 0.1 / speed_mm_per_s;
    const double plain_n = plain.Move(-1.0, 35.0).friction_n;
    EXPECT_GT(plain_n, 0.5);
    EXPECT_NEAR(timed.Move(-1.0, 35.0).friction_n, plain_n, 2e-3 * plain_n) << speed_mm_per_s;
  }
}

TEST(NeedleContactFriction, HoldsMoreAfterARestAndForgetsItInASlip) {
  FemScene scene(WithTimedShaft());
  scene.step_s = 0.02;  // 5 mm/s.
  scene.Move(-1.0, 35.0);
  double peak_n[2] = {};
  for (const int rest : {0, 1}) {
    FemScene& hand = scene;
    const FemNeedleState before = hand.state;
    const double before_s = hand.time_s;
    for (int n = 0; rest == 1 && n < 3000; ++n) hand.StepAt(35.0);  // A minute.
    for (int n = 1; n <= 100; ++n) {
      peak_n[rest] = std::max(peak_n[rest], -hand.StepAt(35.0 - 0.05 * n).friction_n);
    }
    hand.state = before;
    hand.time_s = before_s;
  }
  EXPECT_GT(peak_n[1] / peak_n[0], ShareAt(5.0, 20.0) / ShareAt(5.0, 0.2));
  EXPECT_LT(peak_n[1] / peak_n[0], ShareAt(5.0, 60.1) / ShareAt(5.0, 0.2));
}

TEST(NeedleContactFriction, StrokesTakeWorkWhateverTheRests) {
  FemScene scene(WithTimedShaft());
  scene.Move(-1.0, 25.0);
  double work_n_mm = 0.0, before_mm = 25.0;
  constexpr double kCycle = 2.0 * 3.14159265358979 / 0.02;
  for (int n = 0; n < 10.0 * kCycle; ++n) {
    const double depth_mm = 25.0 - 2.0 * (1.0 - std::cos(0.02 * n));
    scene.step_s = n % 50 == 0 ? 1.0 : 0.001;  // Rests of a second in the strokes.
    const double force_n = -scene.StepAt(depth_mm).force_in_ct_n.dot(Eigen::Vector3d(0, 0, -1));
    if (n > 5.0 * kCycle) work_n_mm += force_n * (depth_mm - before_mm);
    before_mm = depth_mm;
  }
  EXPECT_GT(work_n_mm, 0.0);
}

}  // namespace
}  // namespace acus::tissue
