#include "acus/patient/registration/tracker_quality.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "support/marker_layouts.h"

namespace acus::registration {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// `seconds` at 50 Hz with white noise of the paper's size, drifting by `drift_mm` on the whole.
session::PoseStream Still(double seconds, double drift_mm, double sd_mm = 0.1) {
  session::PoseStream stream;
  RandomStream random(2, "tracker");
  const int count = static_cast<int>(50 * seconds);
  for (int i = 0; i < count; ++i) {
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() = AngleAxisd(0.001 * random.Normal(), Vector3d::UnitX()).matrix();
    pose.translation() = Vector3d(100, 200, 900) + Vector3d(drift_mm * i / (count - 1.0), 0, 0) +
                         sd_mm * Vector3d(random.Normal(), random.Normal(), random.Normal());
    stream.push_back(
        {.time_ns = i * 20'000'000LL, .reference_from_tool = pose, .valid = i % 100 != 7});
  }
  return stream;
}

TEST(MeasureJitter, IsThatOfTheNoise) {
  const Jitter jitter = MeasureJitter(Still(200, 0.0), "probe", 1.0);
  EXPECT_TRUE(jitter.whole_recording);
  EXPECT_NEAR(jitter.rms_mm, 0.1 * std::sqrt(3), 0.003);
  EXPECT_NEAR(jitter.noise_mm, 0.1 * std::sqrt(3), 0.004);
  EXPECT_NEAR(jitter.sd_mm.y(), 0.1, 0.003);
  EXPECT_NEAR(jitter.p95_mm, 0.1 * 2.7955, 0.01);  // 95 % of chi with 3 degrees of freedom.
  EXPECT_NEAR(jitter.rms_deg, 0.001 * 180 / 3.14159, 0.002);
  EXPECT_LT(jitter.drift_mm, 0.03);
  EXPECT_NEAR(jitter.rate_hz, 50.0, 1e-6);
  EXPECT_EQ(jitter.num_invalid, 100U);
}

TEST(MeasureJitter, DistinguishesDriftFromNoise) {
  const Jitter jitter = MeasureJitter(Still(200, 0.8), "probe", 2.0);
  EXPECT_NEAR(jitter.drift_mm, 0.8, 0.03);
  EXPECT_NEAR(jitter.noise_mm, 0.1 * std::sqrt(3), 0.004);
  EXPECT_NEAR(jitter.rms_mm, std::sqrt(0.03 + 0.64 / 12), 0.01);
}

TEST(MeasureJitter, TakesTheLongestStretchInWhichTheToolLaysStill) {
  auto stream = Still(100, 0.0);
  for (std::size_t i = 0; i < 1000; ++i) {  // The first 20 s it is carried about.
    Isometry3d moved = stream[i].reference_from_tool;
    moved.translation().x() += 5.0 * std::sin(0.05 * static_cast<double>(i));
    stream[i].reference_from_tool = moved;
  }
  const Jitter jitter = MeasureJitter(stream, "probe", 1.0);
  EXPECT_FALSE(jitter.whole_recording);
  EXPECT_NEAR(static_cast<double>(jitter.first), 1000, 30);
  EXPECT_NEAR(jitter.rms_mm, 0.1 * std::sqrt(3), 0.005);
}

TEST(MeasureJitter, SeesTheStepOfRoundedNumbers) {
  auto stream = Still(20, 0.0);
  for (auto& sample : stream) {
    Isometry3d rounded = sample.reference_from_tool;
    for (double& x : rounded.translation()) x = std::round(x / 0.125) * 0.125;
    sample.reference_from_tool = rounded;
  }
  EXPECT_NEAR(MeasureJitter(stream, "probe", 1.0).step_mm, 0.125, 1e-9);
}

TEST(MeasureJitter, RefusesWhatIsTooLittle) {
  EXPECT_THAT([] { MeasureJitter(Still(0.1, 0), "probe", 1.0); },
              ThrowsMessage<InputError>(HasSubstr("probe: jitter needs at least 10 valid poses")));
  EXPECT_THAT([] { MeasureJitter(Still(0.5, 0), "probe", 1.0); },
              ThrowsMessage<NoAnswerError>(HasSubstr("lay still")));
  EXPECT_THROW(MeasureJitter(Still(10, 0), "probe", 0.0), InputError);
}

TEST(MeasureAccuracy, IsTheErrorOfDistances) {
  // Two places 100 mm apart, measured as 102.1: the 2010 paper's way.
  transforms::MarkerPairs two;
  two.names = {"A", "B"};
  two.ct_mm = transforms::Markers::Zero(3, 2);
  two.ct_mm(0, 1) = 100.0;
  two.reference_mm = two.ct_mm;
  two.reference_mm(0, 1) = 102.1;
  const PlaceAccuracy accuracy = MeasureAccuracy(two);
  EXPECT_NEAR(accuracy.rms_mm, 2.1, 1e-12);
  EXPECT_NEAR(accuracy.scale, 1.021, 1e-12);
  EXPECT_FALSE(accuracy.has_places);
  two.ct_mm.col(1).setZero();
  EXPECT_THAT([&] { MeasureAccuracy(two); },
              ThrowsMessage<InputError>(HasSubstr("'A' and 'B' are at the same true place")));
}

TEST(MeasureAccuracy, SeparatesScaleFromNoise) {
  transforms::MarkerPairs grid;
  grid.ct_mm.resize(3, 30);
  for (int i = 0; i < 30; ++i) {
    grid.ct_mm.col(i) = 40.0 * Vector3d(i % 5, i / 5, (i * 7) % 3);
    grid.names.push_back("p" + std::to_string(i));
  }
  const transforms::Markers true_mm = testing_support::KnownPose() * grid.ct_mm;
  grid.reference_mm = testing_support::NoisyMarkers(1.01 * true_mm, 0.3, 1);
  const PlaceAccuracy accuracy = MeasureAccuracy(grid);
  EXPECT_NEAR(accuracy.scale, 1.01, 0.0005);
  EXPECT_GT(accuracy.mean_mm, 0.7);
  EXPECT_TRUE(accuracy.has_places);
  EXPECT_EQ(accuracy.distances.size(), 30U * 29 / 2);
  grid.reference_mm = testing_support::NoisyMarkers(true_mm, 0.3, 1);
  // Distances err by the errors of both ends along them: sqrt(2/3) of the localisation error.
  EXPECT_NEAR(MeasureAccuracy(grid).rms_mm, 0.3 * std::sqrt(2.0 / 3.0), 0.05);
  EXPECT_NEAR(MeasureAccuracy(grid).place_rms_mm, 0.3 * std::sqrt(28.0 / 30.0), 0.06);
}

}  // namespace
}  // namespace acus::registration
