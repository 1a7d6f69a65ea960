#include "acus/physics/mechanics/condensation/reachable.h"

#include <gmock/gmock.h>
#include <set>

#include "acus/base/core/error.h"
#include "support/box_mesh.h"

namespace acus::mechanics {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

struct Scene {
  mesh::TetraMesh mesh;
  FreeNodes free;
};

/// A box of 40 x 40 x 40 mm in cells of 5 mm; its floor z = 0 is fixed.
Scene ReachableBox(double jitter = 0.15) {
  Scene scene{testing_support::BoxMesh({8, 8, 8}, {0, 0, 0}, {40, 40, 40}, jitter), {}};
  testing_support::Fix(scene.mesh, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  scene.free = FindFreeNodes(scene.mesh);
  return scene;
}

/// Whether some of many places in the tetrahedron is in the capsule.
bool TouchesBySampling(const mesh::TetraMesh& mesh, int t, const Capsule& capsule) {
  constexpr int kSteps = 14;
  const Eigen::Vector3d along = capsule.to_mm - capsule.from_mm;
  for (int a = 0; a <= kSteps; ++a) {
    for (int b = 0; a + b <= kSteps; ++b) {
      for (int c = 0; a + b + c <= kSteps; ++c) {
        const Eigen::Vector4d w = Eigen::Vector4d(a, b, c, kSteps - a - b - c) / kSteps;
        Eigen::Vector3d x = Eigen::Vector3d::Zero();
        for (int k = 0; k < 4; ++k) x += w[k] * mesh.nodes_mm.col(mesh.tetrahedra(k, t));
        const double s =
            std::clamp((x - capsule.from_mm).dot(along) / along.squaredNorm(), 0.0, 1.0);
        if ((x - capsule.from_mm - s * along).norm() <= capsule.radius_mm) return true;
      }
    }
  }
  return false;
}

TEST(CorridorNodes, AreThoseOfEveryTetrahedronThatTouchesTheCapsule) {
  const Scene scene = ReachableBox();
  const Capsule wide{{11, 23, 45}, {27, 14, 12}, 4.0};
  const Capsule thin{{11, 23, 45}, {27, 14, 12}, 0.3};  // Thinner than any tetrahedron.
  for (const Capsule& capsule : {wide, thin}) {
    const std::vector<int> nodes = CorridorNodes(scene.mesh, scene.free, capsule);
    const std::set<int> reached(nodes.begin(), nodes.end());
    EXPECT_EQ(reached.size(), nodes.size());
    EXPECT_TRUE(std::ranges::is_sorted(nodes));
    // All that sampling finds must be there, and all of it must be near.
    Capsule slightly_wider = capsule;
    slightly_wider.radius_mm += 0.8;
    std::set<int> at_least, at_most;
    for (int t = 0; t < scene.mesh.tetrahedra.cols(); ++t) {
      for (const int node : scene.mesh.tetrahedra.col(t)) {
        if (scene.mesh.fixed_nodes[node]) continue;
        if (TouchesBySampling(scene.mesh, t, capsule)) at_least.insert(node);
        if (TouchesBySampling(scene.mesh, t, slightly_wider)) at_most.insert(node);
      }
    }
    EXPECT_TRUE(std::ranges::includes(reached, at_least));
    EXPECT_TRUE(std::ranges::includes(at_most, reached));
    EXPECT_GT(at_least.size(), 30u);
  }
}

TEST(CorridorNodes, LeavesOutFixedNodes) {
  const Scene scene = ReachableBox();
  for (const int node : CorridorNodes(scene.mesh, scene.free, {{20, 20, 20}, {20, 20, -10}, 6.0})) {
    EXPECT_FALSE(scene.mesh.fixed_nodes[node]);
  }
}

TEST(CorridorNodes, APointInsideOneTetrahedronReachesItsFourNodes) {
  const Scene scene = ReachableBox();
  const Eigen::Vector3d middle = 0.25 * (scene.mesh.nodes_mm.col(scene.mesh.tetrahedra(0, 2000)) +
                                         scene.mesh.nodes_mm.col(scene.mesh.tetrahedra(1, 2000)) +
                                         scene.mesh.nodes_mm.col(scene.mesh.tetrahedra(2, 2000)) +
                                         scene.mesh.nodes_mm.col(scene.mesh.tetrahedra(3, 2000)));
  EXPECT_EQ(CorridorNodes(scene.mesh, scene.free, {middle, middle, 1e-6}).size(), 4u);
}

TEST(CorridorNodes, OutsideTheMeshIsAnErrorThatSaysWhereTheMeshIs) {
  const Scene scene = ReachableBox();
  EXPECT_THAT(
      [&] {
        CorridorNodes(scene.mesh, scene.free, {{90, 0, 0}, {95, 0, 0}, 5.0});
      },
      ThrowsMessage<InputError>(
          ::testing::AllOf(HasSubstr("outside the mesh"), HasSubstr("(40, 40, 40)"))));
}

TEST(SkinNodes, AreOuterNodesNearThePlace) {
  const Scene scene = ReachableBox();
  const std::vector<int> nodes = SkinNodes(scene.mesh, scene.free, {{20, 20, 41}, 12.0});
  EXPECT_EQ(nodes.size(), 21u);  // Points of a lattice of 5 mm within 11.96 mm.
  for (const int node : nodes) EXPECT_EQ(scene.mesh.nodes_mm(2, node), 40.0);
}

TEST(SkinNodes, FarFromTheSkinIsAnErrorThatSaysHowFar) {
  const Scene scene = ReachableBox();
  EXPECT_THAT(
      [&] {
        SkinNodes(scene.mesh, scene.free, {{20, 20, 90}, 12.0});
      },
      ThrowsMessage<InputError>(HasSubstr("is 50 mm away")));
}

TEST(NodesInside, AreWithinTheRadius) {
  const Scene scene = ReachableBox(0.0);
  EXPECT_EQ(NodesInside(scene.mesh, scene.free, {{20, 20, 20}, {20, 20, 20}, 5.0}).size(), 7u);
  EXPECT_TRUE(NodesInside(scene.mesh, scene.free, {{90, 20, 20}, {99, 20, 20}, 5.0}).empty());
}

TEST(Joined, HoldsEachOnce) {
  EXPECT_EQ(Joined({1, 4, 9}, {2, 4}), (std::vector<int>{1, 2, 4, 9}));
}

}  // namespace
}  // namespace acus::mechanics
