// Known answers on public recordings.
#include <gtest/gtest.h>

#include "registration/pivot.h"
#include "support/shared_data.h"

namespace acus::registration {
namespace {

TEST(PivotData, GivesTheStatedAnswer) {
  const auto folder = testing_support::SharedData("registration/pivot");
  if (!folder) GTEST_SKIP() << "test data registration/pivot is not here";
  const auto poses = ReadPoses(*folder);
  ASSERT_EQ(poses.size(), 57U);
  const PivotCalibration result = CalibratePivot(poses);
  // All printed digits of the stated answer.
  EXPECT_LT((result.tip_mm - Eigen::Vector3d(-14.473, 394.634, -7.407)).cwiseAbs().maxCoeff(),
            6e-4);
  EXPECT_LT((result.pivot_mm - Eigen::Vector3d(-804.742, -85.474, -2112.131)).cwiseAbs().maxCoeff(),
            6e-4);
  EXPECT_NEAR(result.residual_coordinate_rms_mm, 1.761, 6e-4);
}

TEST(PivotData, StaysThereWhenLeavingOutPosesThatDoNotFit) {
  const auto folder = testing_support::SharedData("registration/pivot");
  if (!folder) GTEST_SKIP() << "test data registration/pivot is not here";
  const auto poses = ReadPoses(*folder);
  const PivotCalibration all = CalibratePivot(poses);
  const PivotCalibration robust = CalibratePivotRobustly(poses);
  EXPECT_LE(robust.residual_rms_mm, all.residual_rms_mm);
  EXPECT_LT((robust.tip_mm - all.tip_mm).norm(), 5.0 * all.tip_sd_mm.norm());
}

}  // namespace
}  // namespace acus::registration
