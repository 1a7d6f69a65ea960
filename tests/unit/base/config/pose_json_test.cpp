#include "acus/base/config/pose_json.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"

namespace acus::config {
namespace {

using nlohmann::json;

TEST(PoseJson, IsReadAndNormalised) {
  // A quarter of a turn about z; 0.05 % too long.
  const json node = {{"translation_mm", {1.0, 2.0, 3.0}},
                     {"quaternion_wxyz", {0.70746, 0.0, 0.0, 0.70746}}};
  const Eigen::Isometry3d pose = PoseFrom(node, "x");
  EXPECT_LT((pose * Eigen::Vector3d(1.0, 0.0, 0.0) - Eigen::Vector3d(1.0, 3.0, 3.0)).norm(), 1e-12);
  EXPECT_NEAR(pose.linear().determinant(), 1.0, 1e-15);
}

TEST(PoseJson, RefusesWhatIsNoRotation) {
  const json node = {{"translation_mm", {0, 0, 0}}, {"quaternion_wxyz", {0.9, 0, 0, 0}}};
  EXPECT_THAT([&] { PoseFrom(node, "d.json: /needle"); },
              testing::ThrowsMessage<InputError>(
                  testing::HasSubstr("d.json: /needle/quaternion_wxyz: has length 0.9")));
}

TEST(PoseJson, RowsAreReadBackBitForBit) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(0.1, -20.0, 1.0 / 3.0);
  const json rows = json::parse(MatrixRows(pose).dump());
  EXPECT_EQ(rows.at(0).at(3), 0.1);
  EXPECT_EQ(rows.at(3), json({0.0, 0.0, 0.0, 1.0}));
  EXPECT_EQ(PoseFromRows(rows).matrix(), pose.matrix());
  EXPECT_EQ(Row(pose.translation()), json({0.1, -20.0, 1.0 / 3.0}));
}

}  // namespace
}  // namespace acus::config
