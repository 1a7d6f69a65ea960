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
