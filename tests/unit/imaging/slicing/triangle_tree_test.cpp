#include "acus/imaging/slicing/tracing/triangle_tree.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "support/icosphere.h"

namespace acus::tracing {
namespace {

TreeSurface BallOfUnits(double radius, int levels) {
  const mesh::Surface ball = testing_support::Icosphere(radius, levels);
  return {ball.nodes_mm.array().round().cast<std::int32_t>(), ball.triangles};
}

using Found = std::set<std::pair<std::uint32_t, std::uint32_t>>;

void Keep(void* context, std::uint32_t surface, std::uint32_t triangle) {
  static_cast<Found*>(context)->insert({surface, triangle});
}

Found Visited(const TriangleTree& tree, const Place& from, const Place& to) {
  Found found;
  tree.Search(from, to, Keep, &found);
  return found;
}

TEST(TriangleTree, NoTriangleThatASegmentMeetsIsLeftOut) {
  std::vector<TreeSurface> surfaces = {BallOfUnits(4.1e6, 4), BallOfUnits(300.0, 3),
                                       BallOfUnits(20.0, 2)};
  const TriangleTree tree(std::move(surfaces), 1);
  EXPECT_EQ(tree.num_triangles(), 20U * (256 + 64 + 16));
  std::mt19937_64 random(2);
  std::size_t met = 0, visited = 0;
  for (const double reach : {2e1, 3e2, 5e6, 1.3e8}) {
    std::uniform_int_distribution<std::int64_t> at(-static_cast<std::int64_t>(reach),
                                                   static_cast<std::int64_t>(reach));
    for (int n = 0; n < 200; ++n) {
      const Place from = {at(random), at(random), at(random)};
      // Some along an axis, some through the middle, some anywhere.
      const Place to = n % 3 == 0   ? Place{from[0], from[1], -from[2]}
                       : n % 3 == 1 ? Place{-from[0], -from[1], -from[2]}
                                    : Place{at(random), at(random), at(random)};
      const Found found = Visited(tree, from, to);
      visited += found.size();
      for (std::uint32_t s = 0; s < tree.surfaces().size(); ++s) {
        const TreeSurface& surface = tree.surfaces()[s];
        for (std::uint32_t t = 0; t < surface.triangles.cols(); ++t) {
          SegmentCrossing crossing{};
          if (!Crosses(from, to, surface.NodeOf(t, 0), surface.NodeOf(t, 1), surface.NodeOf(t, 2),
                       crossing)) {
            continue;
          }
          ++met;
          EXPECT_TRUE(found.contains({s, t})) << reach << " " << n;
        }
      }
    }
  }
  EXPECT_GT(met, 800U);
  EXPECT_LT(visited, 60U * met);  // Most are left out.
}

TEST(TriangleTree, KnowsWhatIsOutside) {
  std::vector<TreeSurface> surfaces;
  surfaces.push_back(BallOfUnits(1000.0, 3));
  const TriangleTree tree(std::move(surfaces), 1);
  EXPECT_FALSE(tree.IsOutside({0, 0, 1000}));
  EXPECT_TRUE(tree.IsOutside({0, -1100, 0}));
  EXPECT_TRUE(Visited(tree, {-2000, 1100, 0}, {2000, 1100, 0}).empty());
  EXPECT_GT(tree.memory_bytes(), tree.num_triangles() * 12);
  EXPECT_LT(tree.memory_bytes(), tree.num_triangles() * 400);
}

}  // namespace
}  // namespace acus::tracing
