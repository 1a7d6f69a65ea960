#include "acus/patient/registration/temporal.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::registration {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A body that moves and turns at changing speed.
Isometry3d BodyAt(double t) {
  const double phase = 2.0 * t + 0.3 * t * t / 10.0;
  const Vector3d at(40 * std::sin(phase), 25 * std::sin(0.7 * phase + 1.0),
                    15 * std::cos(1.3 * phase));
  return Eigen::Translation3d(at) *
         AngleAxisd(0.4 * std::sin(0.9 * phase), Vector3d(1, 2, 3).normalized());
}

/// The body as a tracker with another frame, another marker and another clock gives it.
session::PoseStream Seen(double rate_hz, double clock_ahead_s, const Isometry3d& frame,
                         const Isometry3d& marker, double noise_mm, std::uint64_t seed) {
  RandomStream random(seed, "temporal");
  session::PoseStream stream;
  for (int i = 0; i < 20 * rate_hz; ++i) {
    const double t = i / rate_hz;
    Isometry3d pose = frame * BodyAt(t) * marker;
    pose.translation() += noise_mm * Vector3d(random.Normal(), random.Normal(), random.Normal());
    stream.push_back({std::llround(1e9 * (t + clock_ahead_s)), transforms::Pose(pose), true});
  }
  return stream;
}

const Isometry3d kFrame = Eigen::Translation3d(300, -20, 50) * AngleAxisd(1.1, Vector3d::UnitY());
const Isometry3d kMarker = Eigen::Translation3d(30, 60, -90) * AngleAxisd(0.5, Vector3d::UnitZ());

TEST(CalibrateTime, FindsTheLagOfTwoTrackersWithinItsStatedError) {
  for (const double lag_s : {-0.0648, 0.0, 0.213}) {
    const auto first = Seen(60, 0.0, Isometry3d::Identity(), Isometry3d::Identity(), 0.1, 1);
    const auto second = Seen(25, -lag_s, kFrame, kMarker, 0.1, 2);
    const auto found = CalibrateTime(first, PositionsOf(second));
    EXPECT_NEAR(found.lag_s, lag_s, 1e-3);
    EXPECT_NEAR(found.lag_s, lag_s, 5.0 * found.sd_s + 2e-4);
    EXPECT_GT(found.explained_share, 0.999);
    EXPECT_LT(found.sd_s, 1e-3);
  }
}

TEST(CalibrateTime, FollowsOneNumberPerImage) {
  const auto first = Seen(60, 0.0, Isometry3d::Identity(), Isometry3d::Identity(), 0.05, 3);
  MotionSignal rows = PositionsOf(Seen(15, 0.0648, kFrame, kMarker, 0.3, 4));
  rows.values = (rows.values.col(1) * -7.3).array().round().matrix().eval();  // Whole pixels.
  EXPECT_NEAR(CalibrateTime(first, rows).lag_s, -0.0648, 2e-3);
}

/// The signals of detectors of one line, on another scale, with errors that no fit here assumes:
/// each late by an amount of its own, noise that goes on from image to image, whole pixels, a slow
/// drift, and now and then an image in which something else is found.
std::vector<MotionSignal> Detectors(int count, double lag_s, double own_lag_s, std::uint64_t seed) {
  RandomStream random(seed, "detectors");
  std::vector<MotionSignal> detectors;
  for (int d = 0; d < count; ++d) {
    const double late_s = lag_s + own_lag_s * random.Normal();
    MotionSignal& signal = detectors.emplace_back();
    std::vector<double> rows;
    double noise_px = 0.0;
    for (int i = 0; i < 300; ++i) {
      const double t = 0.5 + i / 15.0;
      noise_px = 0.8 * noise_px + 1.5 * random.Normal();
      const double row = 200.0 + 3.0 * BodyAt(t + late_s).translation().y() + noise_px + 0.3 * t;
      signal.time_ns.push_back(std::llround(1e9 * t));
      rows.push_back(std::round(random.Uniform() < 0.01 ? row + 30.0 : row));
    }
    signal.values = Eigen::Map<const Eigen::VectorXd>(rows.data(), 300);
  }
  return detectors;
}

/// How often intervals of 95 % hold, and the RMS of the errors over that of the standard errors.
struct Coverage {
  int held = 0;
  double spread = 0.0;
};

Coverage CoverageOf(int count, double own_lag_s, int trials) {
  session::PoseStream tracker;
  for (int i = 0; i < 21 * 60; ++i) {
    const double t = i / 60.0;
    tracker.push_back({std::llround(1e9 * t), transforms::Pose(BodyAt(t)), true});
  }
  Coverage coverage;
  double errors_s2 = 0.0, stated_s2 = 0.0;
  for (int trial = 0; trial < trials; ++trial) {
    const auto found =
        CalibrateTime(tracker, Detectors(count, 0.03, own_lag_s, static_cast<std::uint64_t>(trial)),
                      {.max_lag_s = 0.25});
    const double error_s = found.lag_s - 0.03;
    coverage.held += std::abs(error_s) <= found.half_width_s;
    errors_s2 += error_s * error_s;
    stated_s2 += found.sd_s * found.sd_s;
  }
  coverage.spread = std::sqrt(errors_s2 / stated_s2);
  return coverage;
}

TEST(CalibrateTime, IntervalsHoldAsOftenAsTheySayUnderNoiseThatGoesOn) {
  const Coverage one = CoverageOf(1, 0.0, 100);
  EXPECT_GE(one.held, 88);
  EXPECT_LE(one.held, 99);
  EXPECT_GT(one.spread, 0.75);  // 100 trials: 7 % (SD); the drift shifts all lags by 1.5 ms.
  EXPECT_LT(one.spread, 1.4);
}

TEST(CalibrateTime, IntervalsContainWhatDetectorsDifferBy) {
  const Coverage four = CoverageOf(4, 0.02, 40);
  EXPECT_GE(four.held, 34);
  EXPECT_GT(four.spread, 0.7);  // 40 trials: 11 % (SD).
  EXPECT_LT(four.spread, 1.4);
}

TEST(CalibrateTime, RefusesRecordingsWithoutCommonMotion) {
  const auto first = Seen(60, 0.0, Isometry3d::Identity(), Isometry3d::Identity(), 0.1, 1);
  MotionSignal noise = PositionsOf(first);
  RandomStream random(9, "temporal");
  for (double& value : noise.values.reshaped()) value = random.Normal();
  EXPECT_THAT([&] { CalibrateTime(first, noise); },
              ThrowsMessage<NoAnswerError>(HasSubstr("are both of the same body")));
  EXPECT_THAT([&] { CalibrateTime(first, PositionsOf(Seen(25, 100.0, kFrame, kMarker, 0.1, 2))); },
              ThrowsMessage<InputError>(HasSubstr("--delay-s")));
  EXPECT_THROW(CalibrateTime(first, PositionsOf(Seen(60, -0.4, kFrame, kMarker, 0.1, 2)),
                             {.max_lag_s = 0.2}),
               NoAnswerError);
}

}  // namespace
}  // namespace acus::registration
