// What is hard on a pair of cameras: each case must give a pose within a bound, or one camera's
// pose, or a refusal that says why. Never a wrong pose that claims to be of both.
#include <gtest/gtest.h>
#include <iostream>

#include "support/bound.h"
#include "support/pair_views.h"

namespace acus::camera {
namespace {

using namespace testing_support;

class HardPair : public testing::Test {
 protected:
  PairViews views_{ReadStereo(ConfigPath("cameras/micron_pair_2010.json")),
                   ReadFacets(ConfigPath("facets/training.json"))};
  const FacetObject& object_ = *views_.set().Find("Reference");
  Eigen::Isometry3d truth_ = FacingPose({60, -40, 1000}, 25, 60, 10);

  std::vector<DetectedMarker> Left(const Eigen::Isometry3d& pose) {
    return views_.MarkersInLeft(views_.Left("Reference", pose, 1));
  }
  std::vector<DetectedMarker> Right(const Eigen::Isometry3d& pose) {
    return views_.MarkersInRight(views_.Right("Reference", pose, 1));
  }
  std::optional<PairPose> Locate(const std::vector<DetectedMarker>& left,
                                 const std::vector<DetectedMarker>& right) {
    return LocateObjectInPair(object_, left, right, views_.pair(), {}, std::nullopt);
  }
  void ExpectWithin(const HardCase& hard, const std::optional<PairPose>& found, PairUse use,
                    double position_mm, double angle_deg) {
    ASSERT_TRUE(found);
    EXPECT_EQ(found->use, use);
    const PoseError error = ErrorOf(found->pose.camera_from_object, truth_);
    std::cout << error.position_mm << " mm, " << error.angle_deg << " deg\n";
    hard.Expect("error of position", error.position_mm, Below(position_mm), "mm");
    hard.Expect("error of direction", error.angle_deg, Below(angle_deg), "deg");
  }
  /// Every image of the pair disagrees: it is refused, with what to do.
  static void ExpectRefused(PairUse use) {
    PairAgreement agreement;
    for (int i = 0; i < 15; ++i) {
      EXPECT_FALSE(agreement.refused());
      agreement.Count(use);
    }
    EXPECT_TRUE(agreement.refused());
    EXPECT_NE(agreement.Problem().find("15 times of 15"), std::string::npos);
    agreement.Count(PairUse::kBoth);
    EXPECT_FALSE(agreement.refused());
  }
};

TEST_F(HardPair, Exchanged) {
  const HardCase hard("Left and right exchanged: no pose of both.");
  const auto found = Locate(Right(truth_), Left(truth_));
  ASSERT_TRUE(found);
  hard.Expect("poses of both", found->use == PairUse::kBoth ? 1.0 : 0.0, Below(0.5));
  ExpectRefused(found->use);
}

TEST_F(HardPair, StereoFileOfOtherCameras) {
  const HardCase hard("A stereo file with 150 mm for 120 mm between the cameras.");
  const auto left = Left(truth_), right = Right(truth_);
  StereoPair other = views_.pair();
  other.right_from_left.translation().x() = -150.0;
  const auto found = LocateObjectInPair(object_, left, right, other, {}, std::nullopt);
  ExpectWithin(hard, found, PairUse::kDisagree, 1.0, 0.3);  // The left camera's own.
  ExpectRefused(found->use);
}

TEST_F(HardPair, ACameraThatWasPushed) {
  const HardCase hard("The right camera turned by 1 degree since its calibration.");
  const auto left = Left(truth_), right = Right(truth_);
  StereoPair pushed = views_.pair();
  pushed.right_from_left = Eigen::AngleAxisd(std::numbers::pi / 180.0, Eigen::Vector3d::UnitY()) *
                           pushed.right_from_left;
  const auto found = LocateObjectInPair(object_, left, right, pushed, {}, std::nullopt);
  ExpectWithin(hard, found, PairUse::kDisagree, 1.0, 0.3);
}

TEST_F(HardPair, GrazingFacet) {
  truth_ = FacingPose({60, 0, 1000}, 50, 90, 0);
  const HardCase hard("One facet at 80 degrees from facing.");
  ExpectWithin(hard, Locate(Left(truth_), Right(truth_)), PairUse::kBoth, 0.3, 0.3);
}

TEST_F(HardPair, OneCameraCovered) {
  const HardCase hard("The right camera covered: the left one's pose.");
  ExpectWithin(hard, Locate(Left(truth_), {}), PairUse::kOne, 1.0, 0.3);
}

TEST_F(HardPair, TheOtherCameraCovered) {
  const HardCase hard("The left camera covered: the right one's pose, in the left one's frame.");
  ExpectWithin(hard, Locate({}, Right(truth_)), PairUse::kOne, 1.0, 0.3);
}

TEST_F(HardPair, EachCameraSeesOneFacet) {
  // No corner is seen by both: nothing can be triangulated, and yet all corners count.
  auto left = Left(truth_), right = Right(truth_);
  std::erase_if(left, [](const DetectedMarker& marker) { return marker.id >= 4; });
  std::erase_if(right, [](const DetectedMarker& marker) { return marker.id < 4; });
  const HardCase hard("The left camera sees one facet, the right camera the other.");
  const auto found = Locate(left, right);
  ExpectWithin(hard, found, PairUse::kBoth, 0.3, 0.2);
  EXPECT_EQ(found->pose.corners_used, 32);
}

TEST_F(HardPair, ImagesOfOtherMoments) {
  // 10 mm in the 33 ms between: 300 mm/s.
  Eigen::Isometry3d later = truth_;
  later.translation().y() += 10.0;
  const HardCase hard("The right image 33 ms later, with the object 10 mm away.");
  ExpectWithin(hard, Locate(Left(truth_), Right(later)), PairUse::kDisagree, 1.0, 0.3);
}

TEST_F(HardPair, NothingInEither) {
  EXPECT_FALSE(Locate({}, {}));
}

}  // namespace
}  // namespace acus::camera
