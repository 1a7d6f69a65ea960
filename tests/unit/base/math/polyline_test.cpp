#include "acus/base/math/polyline.h"

#include <gtest/gtest.h>

namespace acus::math {
namespace {

TEST(Polyline, HoldsWhatThereIsRoomFor) {
  Polyline line;
  EXPECT_TRUE(line.empty());
  for (int i = 0; i < Polyline::kMaxPoints + 5; ++i) line.Add({1.0 * i, 0.0, -1.0});
  EXPECT_EQ(line.num_points, Polyline::kMaxPoints);
  EXPECT_EQ(line.At(Polyline::kMaxPoints - 1), Eigen::Vector3d(Polyline::kMaxPoints - 1, 0, -1));
  line.Clear();
  EXPECT_TRUE(line.empty());
}

}  // namespace
}  // namespace acus::math
