#include "acus/run/training/situation.h"

#include <cmath>
#include <gtest/gtest.h>

namespace acus::training {
namespace {

/// Tissue fills y > 0.
volume::Label TissueBelow(const Eigen::Vector3d& point_mm) {
  return point_mm.y() > 0.0 ? 1 : 0;
}

session::PoseSample At(double x, double y, double z) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() << x, y, z;
  return {0, transforms::Pose(pose), true};
}

TEST(Situation, ANeedleIsAtTheSkinWithinThreeMillimetres) {
  const auto at_skin = [](double y_mm, bool down) {
    session::PoseSample needle = At(0.0, y_mm, 0.0);
    Eigen::Isometry3d pose = needle.reference_from_tool.isometry();
    // Its z axis is the way of the needle: down is +y here.
    pose.linear() =
        Eigen::AngleAxisd(down ? -M_PI / 2 : M_PI / 2, Eigen::Vector3d::UnitX()).toRotationMatrix();
    needle.reference_from_tool = transforms::Pose(pose);
    return SituationOf(needle, nullptr, {}, TissueBelow, {}).needle_at_skin;
  };
  EXPECT_TRUE(at_skin(-2.5, true));
  EXPECT_FALSE(at_skin(-3.5, true)) << "too far";
  EXPECT_FALSE(at_skin(-2.5, false)) << "points away";
  EXPECT_FALSE(at_skin(2.0, true)) << "in tissue";
}

TEST(Situation, ContactViewAndPlane) {
  const ImageField field{.depth_mm = 60.0, .half_width_mm = 20.0};
  SituationOptions options;
  options.target_mm = Eigen::Vector3d(5.0, 40.0, 1.0);
  session::PoseSample needle = At(10.0, 30.0, 0.5);
  // Along -x, in the plane of the probe.
  Eigen::Isometry3d pose = needle.reference_from_tool.isometry();
  pose.linear() =
      Eigen::AngleAxisd(1.5707963267948966, Eigen::Vector3d::UnitY()).toRotationMatrix();
  needle.reference_from_tool = transforms::Pose(pose);
  const session::PoseSample probe = At(0.0, 0.0, 0.0);
  const Situation now = SituationOf(needle, &probe, field, TissueBelow, options);
  EXPECT_TRUE(now.probe_on_skin);
  EXPECT_TRUE(now.target_in_view);
  EXPECT_TRUE(now.needle_in_tissue);
  EXPECT_TRUE(now.needle_in_plane);
  EXPECT_NEAR(*now.tip_to_target_mm, std::sqrt(25.0 + 100.0 + 0.25), 1e-12);
  EXPECT_FALSE(now.target_reached);

  const session::PoseSample off = At(0.0, -5.0, 3.0);
  const Situation away = SituationOf(needle, &off, field, TissueBelow, options);
  EXPECT_FALSE(away.probe_on_skin);
  EXPECT_TRUE(away.target_in_view) << "2 mm off the plane, which shows 2 mm";
  EXPECT_FALSE(away.needle_in_plane);
  EXPECT_NEAR(away.target_in_probe_mm->z(), -2.0, 1e-12);
  EXPECT_EQ(GapToSkinMm(off.reference_from_tool, TissueBelow), 6.0);
  EXPECT_FALSE(SituationOf(needle, nullptr, field, TissueBelow, options).probe_seen);
}

TEST(Situation, FieldsOfFlatAndCurvedProbes) {
  const ImageField flat{.depth_mm = 60.0, .half_width_mm = 20.0};
  EXPECT_TRUE(flat.Contains(-20.0, 60.0));
  EXPECT_FALSE(flat.Contains(20.1, 10.0));
  EXPECT_FALSE(flat.Contains(0.0, -0.1));
  const ImageField curved{
      .depth_mm = 100.0, .half_width_mm = 0.0, .radius_mm = 50.0, .half_angle_rad = 0.5};
  EXPECT_TRUE(curved.Contains(0.0, 100.0));
  EXPECT_FALSE(curved.Contains(0.0, 100.1));
  EXPECT_TRUE(curved.Contains(149.9 * std::sin(0.49), 149.9 * std::cos(0.49) - 50.0));
  EXPECT_FALSE(curved.Contains(100.0 * std::sin(0.51), 100.0 * std::cos(0.51) - 50.0));
  EXPECT_FALSE(curved.Contains(49.0 * std::sin(0.2), 49.0 * std::cos(0.2) - 50.0)) << "the face";
}

TEST(Situation, TheDepthOfAProbeIsMeasuredAgainstItsBeam) {
  const auto depth_mm = [](double y_mm) {
    return DepthBelowSkinMm(At(0.0, y_mm, 0.0).reference_from_tool, TissueBelow);
  };
  EXPECT_EQ(depth_mm(-4.0), 0.0);
  EXPECT_EQ(depth_mm(24.0), 24.0);
  EXPECT_EQ(depth_mm(90.0), 60.0) << "no deeper is looked for";
}

}  // namespace
}  // namespace acus::training
