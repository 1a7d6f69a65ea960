#include "acus/patient/registration/hand_eye.h"

#include <algorithm>
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

const Isometry3d kX =
    Eigen::Translation3d(12, -35, 60) * AngleAxisd(0.9, Vector3d(1, 2, -1).normalized());
const Isometry3d kZ =
    Eigen::Translation3d(-400, 150, 900) * AngleAxisd(2.8, Vector3d(-1, 0.3, 2).normalized());

struct Recording {
  std::vector<Isometry3d> handle;
  std::vector<Isometry3d> marker;
};

Vector3d Normal3(RandomStream& random) {
  return {random.Normal(), random.Normal(), random.Normal()};
}

Isometry3d Noise(RandomStream& random, double sd_mm, double sd_rad) {
  const Vector3d turn = sd_rad * Normal3(random);
  Isometry3d jitter = Isometry3d::Identity();
  if (turn.norm() > 0) jitter.linear() = AngleAxisd(turn.norm(), turn.normalized()).matrix();
  jitter.translation() = sd_mm * Normal3(random);
  return jitter;
}

/// A hand that turns the handle by about `turn_rad` about all axes (or one only).
Recording Recorded(int count, double turn_rad, double sd_mm, double sd_rad, bool one_axis = false,
                   std::uint64_t index = 0) {
  RandomStream random(4, "hand eye", index);
  Recording recording;
  for (int i = 0; i < count; ++i) {
    Vector3d turn = turn_rad * Normal3(random);
    if (one_axis) turn = Vector3d(1, 1, 0) * turn.x();
    const Isometry3d handle =
        Eigen::Translation3d(80 * Normal3(random)) * AngleAxisd(turn.norm(), turn.normalized());
    recording.handle.push_back(handle);
    recording.marker.push_back(kZ.inverse() * handle * kX * Noise(random, sd_mm, sd_rad));
  }
  return recording;
}

TEST(RequireOneBody, RefusesPairsOfDifferentMoments) {
  const Recording r = Recorded(60, 0.5, 0.2, 0.001);
  EXPECT_NO_THROW(RequireOneBody(CalibrateHandEye(r.handle, r.marker), 5.0));
  auto late = r.marker;
  std::ranges::rotate(late, late.begin() + 1);
  EXPECT_THAT([&] { RequireOneBody(CalibrateHandEye(r.handle, late), 5.0); },
              ThrowsMessage<NoAnswerError>(HasSubstr("not of the same moments")));
}

TEST(RequireOneBody, SaysHowManyPairsAreUsed) {
  HandEye result;
  result.rms_mm = 1.0;
  result.used.assign(40, true);
  std::fill_n(result.used.begin(), 18, false);
  EXPECT_THAT([&] { RequireOneBody(result, 5.0); },
              ThrowsMessage<NoAnswerError>(HasSubstr("over 55 % of 40 pairs")));
  std::fill_n(result.used.begin(), 16, true);  // 95 %.
  EXPECT_NO_THROW(RequireOneBody(result, 5.0));
  EXPECT_THAT([&] { RequireOneBody(result, 0.9); },
              ThrowsMessage<NoAnswerError>(HasSubstr("over 95 % of 40 pairs")));
}

TEST(CalibrateHandEye, IsExactWithoutNoise) {
  for (const int count : {4, 8, 50}) {
    const Recording r = Recorded(count, 0.5, 0, 0);
    const HandEye result = CalibrateHandEye(r.handle, r.marker);
    EXPECT_TRUE(result.handle_from_marker.isApprox(kX, 1e-10)) << count;
    EXPECT_TRUE(result.device_from_tracker.isApprox(kZ, 1e-10)) << count;
    EXPECT_LT(result.rms_mm, 1e-8);
  }
}

TEST(CalibrateHandEye, ErrsAsMuchAsItSays) {
  double error2 = 0, said2 = 0, device2 = 0, device_said2 = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Recording r = Recorded(40, 0.4, 0.15, 0.0015, false, seed);
    const HandEye result = CalibrateHandEye(r.handle, r.marker);
    error2 += (result.handle_from_marker.translation() - kX.translation()).squaredNorm();
    said2 += result.handle_sd_mm.squaredNorm();
    device2 += (result.device_from_tracker.translation() - kZ.translation()).squaredNorm();
    device_said2 += result.device_sd_mm.squaredNorm();
  }
  EXPECT_NEAR(std::sqrt(error2 / said2), 1.0, 0.2);
  EXPECT_NEAR(std::sqrt(device2 / device_said2), 1.0, 0.2);
  EXPECT_LT(std::sqrt(error2 / 60), 0.1);
}

TEST(CalibrateHandEye, LeavesOutWrongPairs) {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    Recording r = Recorded(40, 0.4, 0.1, 0.001, false, seed);
    for (std::size_t i = 0; i < 10; ++i) r.marker[4 * i] = r.marker[(4 * i + 17) % 40];
    const HandEye result = CalibrateHandEye(r.handle, r.marker);
    EXPECT_LT((result.handle_from_marker.translation() - kX.translation()).norm(), 0.3) << seed;
    for (std::size_t i = 0; i < 10; ++i) EXPECT_FALSE(result.used[4 * i]) << seed;
  }
}

TEST(CalibrateHandEye, RefusesTurnsAboutOneAxis) {
  const Recording r = Recorded(30, 0.5, 0.1, 0.001, true);
  EXPECT_THAT([&] { CalibrateHandEye(r.handle, r.marker); },
              ThrowsMessage<NoAnswerError>(HasSubstr("two different axes")));
  const Recording still = Recorded(30, 0.001, 0.1, 0.001);
  EXPECT_THAT([&] { CalibrateHandEye(still.handle, still.marker); },
              ThrowsMessage<NoAnswerError>(HasSubstr("turned by only")));
  EXPECT_THAT([&] { CalibrateHandEye(std::span(r.handle).first(3), std::span(r.marker).first(3)); },
              ThrowsMessage<InputError>(HasSubstr("at least 4")));
  EXPECT_THAT([&] { CalibrateHandEye(r.handle, std::span(r.marker).first(7)); },
              ThrowsMessage<InputError>(HasSubstr("but 7 of the marker")));
}

TEST(SolveAxXb, AgreesWithAxZb) {
  const Recording r = Recorded(12, 0.5, 0, 0);
  std::vector<Isometry3d> a, b;
  for (std::size_t i = 1; i < r.handle.size(); ++i) {
    a.push_back(r.handle[i - 1].inverse() * r.handle[i]);
    b.push_back(r.marker[i - 1].inverse() * r.marker[i]);
  }
  EXPECT_TRUE(SolveAxXb(a, b).isApprox(kX, 1e-9));
  EXPECT_THAT([&] { SolveAxXb(std::span(a).first(1), std::span(b).first(1)); },
              ThrowsMessage<InputError>(HasSubstr("at least 2")));
}

}  // namespace
}  // namespace acus::registration
