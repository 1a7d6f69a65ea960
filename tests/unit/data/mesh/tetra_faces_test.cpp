#include "acus/data/mesh/tetra_faces.h"

#include <gtest/gtest.h>

#include "support/box_mesh.h"

namespace acus::mesh {
namespace {

TEST(TetraFaces, InnerFacesComeTwiceAndOuterOnesOnce) {
  const TetraMesh box = testing_support::BoxMesh({3, 2, 2}, {0, 0, 0}, {3, 2, 2});
  const std::vector<TetraFace> faces = SortedFaces(box);
  ASSERT_EQ(faces.size(), 4u * 3 * 2 * 2 * 6);
  int num_single = 0;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool is_shared = (i > 0 && faces[i].IsSameFace(faces[i - 1])) ||
                           (i + 1 < faces.size() && faces[i].IsSameFace(faces[i + 1]));
    num_single += is_shared ? 0 : 1;
  }
  EXPECT_EQ(num_single, 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2));  // Two triangles per square.
}

TEST(TetraFaces, OuterNodesAreThoseOnTheBoxsSides) {
  const TetraMesh box = testing_support::BoxMesh({3, 3, 3}, {0, 0, 0}, {3, 3, 3});
  const std::vector<std::uint8_t> is_outer = OuterNodes(box);
  for (int i = 0; i < box.nodes_mm.cols(); ++i) {
    const Eigen::Vector3d x = box.nodes_mm.col(i);
    EXPECT_EQ(is_outer[i] != 0, x.minCoeff() == 0.0 || x.maxCoeff() == 3.0) << x.transpose();
  }
}

}  // namespace
}  // namespace acus::mesh
