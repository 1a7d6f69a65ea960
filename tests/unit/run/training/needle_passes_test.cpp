#include "acus/run/training/needle_passes.h"

#include <cmath>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/math/rigid.h"

namespace acus::training {
namespace {

using session::PoseStream;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr double kDegree = 0.017453292519943295;

/// Tissue fills z > 0; the needle comes from above (its +z into the tissue).
bool Below(const Eigen::Vector3d& point_mm) {
  return point_mm.z() > 0.0;
}

/// A needle stream that is led by waypoints of (depth along the shaft, tilt), through the entry at
/// the origin, in steps of 0.25 mm and 0.25 degree, 1 ms apart.
class Hand {
 public:
  Hand& To(double depth_mm, double tilt_deg) {
    const int steps = static_cast<int>(
        std::ceil(4.0 * std::max(std::abs(depth_mm - depth_mm_), std::abs(tilt_deg - tilt_deg_))));
    for (int i = 1; i <= std::max(1, steps); ++i) {
      const double t = static_cast<double>(i) / std::max(1, steps);
      Add(depth_mm_ + t * (depth_mm - depth_mm_), tilt_deg_ + t * (tilt_deg - tilt_deg_));
    }
    depth_mm_ = depth_mm;
    tilt_deg_ = tilt_deg;
    return *this;
  }
  const PoseStream& stream() const { return stream_; }

 private:
  void Add(double depth_mm, double tilt_deg) {
    const Eigen::Vector3d axis(std::sin(tilt_deg * kDegree), 0.0, std::cos(tilt_deg * kDegree));
    stream_.push_back(
        {time_ns_, math::PoseFromAxes(depth_mm * axis, axis, Eigen::Vector3d::UnitY()), true});
    time_ns_ += 1'000'000;
  }
  PoseStream stream_;
  std::int64_t time_ns_ = 0;
  double depth_mm_ = -20.0;
  double tilt_deg_ = 0.0;
};

TEST(NeedlePasses, AStraightInsertionIsOnePass) {
  const Hand hand = Hand().To(40.0, 0.0).To(-20.0, 0.0);
  const auto passes = FindPasses(hand.stream(), Below);
  ASSERT_EQ(passes.size(), 1);
  EXPECT_EQ(passes[0].attempt, 0);
  EXPECT_FALSE(passes[0].redirected);
  EXPECT_NEAR(passes[0].advance_mm, 39.75, 1e-9);  // From the first sample in tissue.
  EXPECT_NEAR(passes[0].tip_mm.z(), 40.0, 1e-9);
  EXPECT_EQ(passes[0].end_ns, hand.stream()[239].time_ns);
}

TEST(NeedlePasses, ATurnOfTheNeedleAfterDrawingBackIsARedirection) {
  const Hand hand =
      Hand().To(40.0, 0.0).To(10.0, 0.0).To(10.0, 8.0).To(45.0, 8.0).To(20.0, 8.0).To(50.0, 8.0);
  const auto passes = FindPasses(hand.stream(), Below);
  ASSERT_EQ(passes.size(), 3);
  EXPECT_TRUE(passes[1].redirected);
  EXPECT_FALSE(passes[2].redirected) << "the same line again";
  EXPECT_EQ(passes[2].attempt, 0);
  // Turning about the entry moves the tip sideways, not along the shaft, but for the chord.
  EXPECT_NEAR(passes[1].advance_mm, 35.0, 0.01);
  EXPECT_NEAR(std::acos(passes[1].axis.z()) / kDegree, 8.0, 1e-6);
}

TEST(NeedlePasses, ANewEntryIsAnAttemptNotARedirection) {
  const Hand hand = Hand().To(40.0, 0.0).To(-10.0, 0.0).To(-10.0, 12.0).To(40.0, 12.0);
  const auto passes = FindPasses(hand.stream(), Below);
  ASSERT_EQ(passes.size(), 2);
  EXPECT_EQ(passes[1].attempt, 1);
  EXPECT_FALSE(passes[1].redirected);
}

TEST(NeedlePasses, TremorIsNoPass) {
  Hand hand;
  hand.To(30.0, 0.0);
  for (int i = 0; i < 50; ++i) hand.To(28.0, 0.0).To(32.0, 0.5);
  EXPECT_EQ(FindPasses(hand.stream(), Below).size(), 1);
  PassOptions fine;
  fine.turn_mm = 3.0;
  EXPECT_EQ(FindPasses(hand.stream(), Below, fine).size(), 50);
  // A needle that trembles through the skin makes one attempt.
  Hand at_skin;
  for (int i = 0; i < 20; ++i) at_skin.To(1.0, 0.0).To(-1.0, 0.0);
  at_skin.To(20.0, 0.0);
  const auto passes = FindPasses(at_skin.stream(), Below);
  ASSERT_EQ(passes.size(), 1);
  EXPECT_EQ(passes[0].attempt, 0);
}

TEST(NeedlePasses, InvalidSamplesAreExcluded) {
  Hand hand = Hand().To(40.0, 0.0);
  PoseStream stream = hand.stream();
  for (std::size_t i = 100; i < 120; ++i) {
    stream[i].valid = false;
    stream[i].reference_from_tool = math::PoseFromAxes(
        {500.0, 0.0, -500.0}, Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX());
  }
  const auto passes = FindPasses(stream, Below);
  ASSERT_EQ(passes.size(), 1);
  EXPECT_NEAR(passes[0].advance_mm, 39.75, 1e-9);
  EXPECT_TRUE(FindPasses({}, Below).empty());
}

TEST(NeedlePasses, RefusesOptionsOutOfRange) {
  const auto with = [](auto set) {
    return [set] {
      PassOptions options;
      set(options);
      FindPasses({}, Below, options);
    };
  };
  EXPECT_THAT(with([](auto& o) { o.turn_mm = 0.0; }),
              ThrowsMessage<InputError>(HasSubstr("turn_mm")));
  EXPECT_THAT(with([](auto& o) { o.redirection_rad = 3.3; }),
              ThrowsMessage<InputError>(HasSubstr("redirection_rad")));
  EXPECT_THAT(with([](auto& o) { o.withdrawal_mm = -1.0; }),
              ThrowsMessage<InputError>(HasSubstr("withdrawal_mm")));
}

}  // namespace
}  // namespace acus::training
