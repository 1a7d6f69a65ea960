#include "acus/physics/mechanics/elements/face_neighbours.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <set>

#include "support/box_mesh.h"

namespace acus::mechanics {
namespace {

TEST(FaceNeighbours, ShareTheThreeNodesOppositeToTheCorner) {
  const mesh::TetraMesh box = testing_support::BoxMesh({3, 2, 4}, {0, 0, 0}, {3, 2, 4});
  const Eigen::Matrix4Xi neighbours = FaceNeighbours(box);
  int num_outer = 0;
  for (int t = 0; t < neighbours.cols(); ++t) {
    for (int c = 0; c < 4; ++c) {
      const int other = neighbours(c, t);
      num_outer += other < 0;
      if (other < 0) continue;
      std::set<int> common(box.tetrahedra.col(other).begin(), box.tetrahedra.col(other).end());
      EXPECT_FALSE(common.contains(box.tetrahedra(c, t)));
      for (int k = 0; k < 4; ++k) {
        EXPECT_TRUE(k == c || common.contains(box.tetrahedra(k, t)));
      }
      EXPECT_EQ(std::ranges::count(neighbours.col(other), t), 1);
    }
  }
  EXPECT_EQ(num_outer, 2 * 2 * (3 * 2 + 2 * 4 + 3 * 4));  // Two triangles per square.
}

}  // namespace
}  // namespace acus::mechanics
