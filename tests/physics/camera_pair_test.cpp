// A pair of cameras against its left one alone, by depth, on rendered images. The tables of pairs
// in docs/models/camera.md are what this prints.
#include <gtest/gtest.h>
#include <iomanip>
#include <iostream>

#include "acus/base/math/statistics.h"
#include "support/pair_views.h"

namespace acus::camera {
namespace {

using namespace testing_support;

constexpr int kViewsAtEachDepth = 12;

/// Of the middle of the probe's markers.
struct ErrorsAtDepth {
  std::vector<double> position_mm, angle_deg;
};

/// The probe's facets look along -z; turned so that they look at the camera.
Eigen::Isometry3d ProbeFacing(const Eigen::Vector3d& at_mm, double tilt_deg, double azimuth_deg,
                              double roll_deg, const Eigen::Vector3d& middle) {
  const Eigen::Isometry3d turn(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  return FacingPose(at_mm, tilt_deg, azimuth_deg, roll_deg) * turn.inverse() *
         Eigen::Translation3d(-middle);
}

Eigen::Vector3d MiddleOf(const FacetObject& object) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Marker& marker : object.markers) {
    middle += marker.object_from_marker.translation() / static_cast<double>(object.markers.size());
  }
  return middle;
}

class PairByDepth : public testing::Test {
 protected:
  PairViews views_{ReadStereo(ConfigPath("cameras/micron_pair_2010.json")),
                   ReadFacets(ConfigPath("facets/training.json"))};
  const FacetObject& probe_ = *views_.set().Find("Probe");
  Eigen::Vector3d middle_ = MiddleOf(probe_);

  static void Add(const ObjectPose& pose, const Eigen::Isometry3d& truth,
                  const Eigen::Vector3d& middle, ErrorsAtDepth& errors) {
    const PoseError error = ErrorOf(pose.camera_from_object, truth, middle);
    errors.position_mm.push_back(error.position_mm);
    errors.angle_deg.push_back(error.angle_deg);
  }
};

TEST_F(PairByDepth, IsNearerToTheTruthThanOneCamera) {
  std::cout << "depth mm | one camera: position RMS mm, largest, angle RMS deg | pair: the same\n";
  for (const double depth_mm : {400.0, 600.0, 800.0, 1000.0, 1250.0, 1500.0}) {
    ErrorsAtDepth one, both;
    for (int i = 0; i < kViewsAtEachDepth; ++i) {
      RandomStream random(11, "pair", static_cast<std::uint64_t>(i));
      const double x_mm = 60.0 + random.Uniform(-0.05, 0.05) * depth_mm;
      const double y_mm = random.Uniform(-0.1, 0.1) * depth_mm;
      const double tilt_deg = random.Uniform(0, 35), azimuth_deg = random.Uniform(0, 360);
      const Eigen::Isometry3d truth = ProbeFacing({x_mm, y_mm, depth_mm}, tilt_deg, azimuth_deg,
                                                  random.Uniform(-180, 180), middle_);
      const auto number = static_cast<std::uint64_t>(i);
      const auto left = views_.MarkersInLeft(views_.Left("Probe", truth, number));
      const auto right = views_.MarkersInRight(views_.Right("Probe", truth, number));
      const auto alone = LocateObject(probe_, left, views_.pair().left, {}, std::nullopt);
      const auto found = LocateObjectInPair(probe_, left, right, views_.pair(), {}, std::nullopt);
      ASSERT_TRUE(alone && found);
      EXPECT_EQ(found->use, PairUse::kBoth);
      Add(*alone, truth, middle_, one);
      Add(found->pose, truth, middle_, both);
    }
    const auto print = [](const ErrorsAtDepth& errors) {
      std::cout << math::RootMeanSquare(errors.position_mm) << ", "
                << *std::ranges::max_element(errors.position_mm) << ", "
                << math::RootMeanSquare(errors.angle_deg);
    };
    std::cout << std::fixed << std::setprecision(3) << depth_mm << " | ";
    print(one);
    std::cout << " | ";
    print(both);
    std::cout << "\n";
    EXPECT_LT(math::RootMeanSquare(both.position_mm), math::RootMeanSquare(one.position_mm));
    // Further away the markers are below 30 px a side, where corners are biased alike in both.
    const bool is_near = depth_mm <= 1000.0;
    for (const double error_mm : both.position_mm) EXPECT_LT(error_mm, is_near ? 0.5 : 1.5);
    if (!is_near) continue;
    EXPECT_LT(math::RootMeanSquare(both.position_mm), 0.6 * math::RootMeanSquare(one.position_mm));
    EXPECT_LT(math::RootMeanSquare(both.angle_deg), math::RootMeanSquare(one.angle_deg));
  }
}

TEST_F(PairByDepth, JitterOfTheProbeAtRest) {
  const Eigen::Isometry3d truth = ProbeFacing({60, -30, 1000}, 20, 70, 15, middle_);
  std::vector<Eigen::Vector3d> by_one, by_pair;
  std::optional<Eigen::Isometry3d> before_one, before_pair;
  for (std::uint64_t i = 0; i < 30; ++i) {
    const auto left = views_.MarkersInLeft(views_.Left("Probe", truth, i));
    const auto right = views_.MarkersInRight(views_.Right("Probe", truth, i));
    const auto alone = LocateObject(probe_, left, views_.pair().left, {}, before_one);
    const auto found = LocateObjectInPair(probe_, left, right, views_.pair(), {}, before_pair);
    ASSERT_TRUE(alone && found);
    before_one = alone->camera_from_object;
    before_pair = found->pose.camera_from_object;
    by_one.push_back(*before_one * middle_);
    by_pair.push_back(*before_pair * middle_);
  }
  const auto jitter_mm = [](const std::vector<Eigen::Vector3d>& points) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const auto& point : points) mean += point / static_cast<double>(points.size());
    double sum = 0.0;
    for (const auto& point : points) sum += (point - mean).squaredNorm();
    return std::sqrt(sum / static_cast<double>(points.size()));
  };
  std::cout << "jitter of the probe 1 m away: one camera " << jitter_mm(by_one) << ", pair "
            << jitter_mm(by_pair) << " mm RMS\n";
  EXPECT_LT(jitter_mm(by_pair), 0.173) << "the stereo tracker of 2010";
  EXPECT_LT(jitter_mm(by_pair), jitter_mm(by_one));
}

}  // namespace
}  // namespace acus::camera
