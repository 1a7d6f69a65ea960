#include "acus/patient/registration/touches.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::registration {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::SizeIs;
using testing::ThrowsMessage;

const Vector3d kTouchesTipMm(2, -5, 140);

/// 2 s at each place, tilting about the tip with `tilt_rad`, 1 s on the way, at 30 Hz.
session::PoseStream TouchesRecorded(const std::vector<Vector3d>& places_mm, double tilt_rad) {
  session::PoseStream stream;
  RandomStream random(3, "touch");
  std::int64_t time_ns = 5'000'000'000;
  for (std::size_t k = 0; k < places_mm.size(); ++k) {
    for (int i = 0; i < 90; ++i, time_ns += 33'333'333) {
      const double share = std::max(0, i - 60) / 30.0;
      const Vector3d& next = places_mm[std::min(k + 1, places_mm.size() - 1)];
      const Vector3d tip = places_mm[k] + share * (next - places_mm[k]) +
                           0.05 * Vector3d(random.Normal(), random.Normal(), random.Normal());
      Isometry3d pose = Isometry3d::Identity();
      pose.linear() =
          AngleAxisd(tilt_rad * std::sin(0.1 * i), Vector3d(1, 0.5, 0).normalized()).matrix();
      pose.translation() = tip - pose.linear() * kTouchesTipMm;
      stream.push_back({.time_ns = time_ns, .reference_from_tool = pose, .valid = i != 20});
    }
  }
  return stream;
}

const std::vector<Vector3d> kPlacesMm = {{0, 0, 0}, {60, 0, 10}, {60, 50, 0}, {0, 50, -20}};

TEST(FindTouches, FindsWhereTheTipRested) {
  for (const double tilt_rad : {0.0, 0.5}) {
    const auto touches = FindTouches(TouchesRecorded(kPlacesMm, tilt_rad), kTouchesTipMm, {});
    ASSERT_THAT(touches, SizeIs(4));
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LT((touches[i].reference_mm - kPlacesMm[i]).norm(), 0.05) << i;
      EXPECT_NEAR(touches[i].rms_mm, 0.05 * std::sqrt(3), 0.02) << i;
      EXPECT_GE(touches[i].num_samples, 30U);
    }
  }
}

TEST(FindTouches, DistinguishesPivotingFromStandingStill) {
  TouchSettings settings;
  settings.shaft_mm = 30.0;
  EXPECT_THAT(FindTouches(TouchesRecorded(kPlacesMm, 0.0), kTouchesTipMm, settings), SizeIs(0));
  EXPECT_THAT(FindTouches(TouchesRecorded(kPlacesMm, 0.5), kTouchesTipMm, settings), SizeIs(4));
}

TEST(FindTouches, TakesAPlaceThatIsTouchedTwiceAsOne) {
  auto places_mm = kPlacesMm;
  places_mm.push_back(kPlacesMm[1] + Vector3d(0.5, 0, 0));
  const auto touches = FindTouches(TouchesRecorded(places_mm, 0.0), kTouchesTipMm, {});
  ASSERT_THAT(touches, SizeIs(4));
  EXPECT_NEAR(touches[1].reference_mm.x(), 60.25, 0.3);
}

TEST(FindTouches, AveragesFromTheFirstMomentUpToBeforeTheLast) {
  session::PoseStream stream;
  for (int i = 0; i < 30; ++i) {  // 10 Hz; the tip creeps by 0.01 mm a sample.
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() = Vector3d(0.01 * i, 0, 0) - kTouchesTipMm;
    stream.push_back({.time_ns = i * 100'000'000LL, .reference_from_tool = pose, .valid = true});
  }
  TouchSettings settings;
  settings.average_from_s = 0.2;
  settings.average_to_s = 0.5;
  const auto touches = FindTouches(stream, kTouchesTipMm, settings);
  ASSERT_THAT(touches, SizeIs(1));
  EXPECT_EQ(touches[0].start_ns, 0);
  EXPECT_EQ(touches[0].num_samples, 3U);  // 0.2, 0.3 and 0.4 s.
  EXPECT_NEAR(touches[0].reference_mm.x(), 0.03, 1e-9);
}

TEST(FindTouches, RefusesSettingsThatMakeNoSense) {
  const auto stream = TouchesRecorded(kPlacesMm, 0.0);
  const auto with = [&](auto change) {
    TouchSettings settings;
    change(settings);
    return [&stream, settings] { FindTouches(stream, kTouchesTipMm, settings); };
  };
  using S = TouchSettings;
  EXPECT_THROW(with([](S& s) { s.window_s = 0.0; })(), InputError);
  EXPECT_THROW(with([](S& s) { s.least_s = 0.1; })(), InputError);
  EXPECT_THROW(with([](S& s) { s.still_mm = 0.0; })(), InputError);
  EXPECT_THROW(with([](S& s) { s.shaft_mm = -1.0; })(), InputError);
  EXPECT_THROW(with([](S& s) { s.average_to_s = 0.0; })(), InputError);
  EXPECT_THROW(FindTouches({}, kTouchesTipMm, {}), InputError);
}

TEST(NamedTouches, SaysWhenAPointIsMissing) {
  const auto touches = FindTouches(TouchesRecorded(kPlacesMm, 0.0), kTouchesTipMm, {});
  transforms::Landmarks known{"known.csv", {"A", "B", "C", "D"}, transforms::Markers::Zero(3, 4)};
  EXPECT_EQ(NamedTouches(touches, known, "run").names[2], "C");
  known.points_mm = transforms::Markers::Zero(3, 5);
  EXPECT_THAT(
      [&] { NamedTouches(touches, known, "run"); },
      ThrowsMessage<InputError>(HasSubstr("run: the tip rested at 4 places (at 5.0 s, 8.")));
}

TEST(ChooseTouches, PassesOverRestsElsewhere) {
  auto places_mm = kPlacesMm;
  places_mm.insert(places_mm.begin(), Vector3d(150, 20, 90));  // On the table before.
  places_mm.insert(places_mm.begin() + 3, Vector3d(30, 90, 40));
  const auto touches = FindTouches(TouchesRecorded(places_mm, 0.0), kTouchesTipMm, {});
  ASSERT_THAT(touches, SizeIs(6));
  transforms::Landmarks known{"known.csv", {"A", "B", "C", "D"}, transforms::Markers(3, 4)};
  for (Eigen::Index i = 0; i < 4; ++i) {
    known.points_mm.col(i) =
        AngleAxisd(1.0, Vector3d::UnitZ()) * kPlacesMm[static_cast<std::size_t>(i)];
  }
  const auto chosen = ChooseTouches(touches, known);
  ASSERT_THAT(chosen, SizeIs(4));
  EXPECT_EQ(chosen[0].start_ns, touches[1].start_ns);
  EXPECT_EQ(chosen[2].start_ns, touches[4].start_ns);
  known.points_mm *= 3.0;  // Another layout: nothing is chosen.
  EXPECT_THAT(ChooseTouches(touches, known), SizeIs(6));
}

TEST(SweptPoints, KeepsTheirDistance) {
  const transforms::Landmarks swept =
      SweptPoints(TouchesRecorded(kPlacesMm, 0.3), kTouchesTipMm, 5.0, "run");
  ASSERT_GT(swept.points_mm.cols(), 20);
  for (Eigen::Index i = 1; i < swept.points_mm.cols(); ++i) {
    EXPECT_GE((swept.points_mm.col(i) - swept.points_mm.col(i - 1)).norm(), 5.0);
  }
}

}  // namespace
}  // namespace acus::registration
