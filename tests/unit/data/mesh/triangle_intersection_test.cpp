#include "acus/data/mesh/triangle_intersection.h"

#include <gtest/gtest.h>

namespace acus::mesh {
namespace {

const Triangle kFlat = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(2, 0, 0),
                        Eigen::Vector3d(0, 2, 0)};

Triangle Moved(const Triangle& t, double x, double y, double z) {
  Triangle out = t;
  for (auto& p : out) p += Eigen::Vector3d(x, y, z);
  return out;
}

TEST(TrianglesIntersect, DistinguishesCrossingTouchingAndSeparate) {
  const Triangle upright = {Eigen::Vector3d(0.5, 0.5, -1), Eigen::Vector3d(0.5, 0.5, 1),
                            Eigen::Vector3d(3, 3, 0)};
  EXPECT_TRUE(TrianglesIntersect(kFlat, upright));
  EXPECT_FALSE(TrianglesIntersect(kFlat, Moved(upright, 2, 2, 0)));
  EXPECT_FALSE(TrianglesIntersect(kFlat, Moved(kFlat, 0, 0, 1e-9)));
  EXPECT_TRUE(TrianglesIntersect(kFlat, Moved(upright, 0, 0, 1.0)));  // A corner on the face.
}

TEST(TrianglesIntersect, WorksInOnePlane) {
  EXPECT_TRUE(TrianglesIntersect(kFlat, Moved(kFlat, 0.5, 0.5, 0)));
  EXPECT_FALSE(TrianglesIntersect(kFlat, Moved(kFlat, 1.5, 1.5, 0)));
  Triangle small = kFlat;
  for (auto& p : small) p = 0.1 * p + Eigen::Vector3d(0.3, 0.3, 0);
  EXPECT_TRUE(TrianglesIntersect(kFlat, small));  // Wholly inside, no edge crossed.
  EXPECT_TRUE(TrianglesIntersect(small, kFlat));
}

TEST(IntersectingPairs, ForgivesSharedNodesAndEdgesButNotFolds) {
  Surface surface;
  surface.nodes_mm.resize(3, 5);
  surface.nodes_mm.transpose() << 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0.2, 0.2, 0;
  surface.triangles.resize(3, 2);
  surface.triangles.transpose() << 0, 1, 2, 1, 3, 2;  // A square of two.
  EXPECT_TRUE(IntersectingPairs(surface, 10).empty());
  surface.triangles.transpose() << 0, 1, 2, 1, 4, 2;  // Folded onto itself.
  EXPECT_EQ(IntersectingPairs(surface, 10).size(), 1U);
  surface.nodes_mm.col(4) << 0.2, 0.2, 0.5;  // Opened.
  EXPECT_TRUE(IntersectingPairs(surface, 10).empty());
}

}  // namespace
}  // namespace acus::mesh
