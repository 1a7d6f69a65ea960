#include "acus/imaging/slicing/tracing/exact_crossing.h"

#include <gtest/gtest.h>
#include <random>
#include <vector>

namespace acus::tracing {
namespace {

using Triangles = std::vector<std::array<Place, 3>>;

/// Faces of the octahedron |x| + |y| + |z| = size, outwards.
Triangles Octahedron(std::int64_t size) {
  Triangles out;
  for (const std::int64_t x : {-size, size}) {
    for (const std::int64_t y : {-size, size}) {
      for (const std::int64_t z : {-size, size}) {
        const bool turned = x * y * z > 0;
        const Place a = {x, 0, 0}, b = {0, y, 0}, c = {0, 0, z};
        out.push_back(turned ? std::array<Place, 3>{a, b, c} : std::array<Place, 3>{a, c, b});
      }
    }
  }
  return out;
}

/// Of all crossings of a segment, in either order.
int TurnsAlong(const Triangles& surface, const Place& from, const Place& to) {
  int sum = 0;
  for (const auto& t : surface) {
    SegmentCrossing crossing{};
    if (Crosses(from, to, t[0], t[1], t[2], crossing)) sum += crossing.turn;
  }
  return sum;
}

TEST(ExactCrossing, SaysWhereAndWhichWay) {
  SegmentCrossing out{};
  // The normal points to +z.
  const Place a = {0, 0, 0}, b = {10, 0, 0}, c = {0, 10, 0};
  ASSERT_TRUE(Crosses({2, 3, 6}, {2, 3, -2}, a, b, c, out));
  EXPECT_DOUBLE_EQ(out.share, 0.75);
  EXPECT_EQ(out.turn, 1);
  ASSERT_TRUE(Crosses({2, 3, -2}, {2, 3, 6}, a, b, c, out));
  EXPECT_DOUBLE_EQ(out.share, 0.25);
  EXPECT_EQ(out.turn, -1);
  EXPECT_FALSE(Crosses({2, 3, 6}, {2, 3, 1}, a, b, c, out));           // Ends before it.
  EXPECT_FALSE(Crosses({9, 9, 6}, {9, 9, -2}, a, b, c, out));          // Beside it.
  EXPECT_FALSE(Crosses({-5, 3, 0}, {20, 3, 0}, a, b, c, out));         // Within its plane.
  EXPECT_FALSE(Crosses({2, 3, 6}, {2, 3, 6}, a, b, c, out));           // No segment.
  EXPECT_FALSE(Crosses({2, 3, 6}, {2, 3, -2}, a, {5, 0, 0}, b, out));  // No area.
}

TEST(ExactCrossing, PathsThroughNodesAndEdgesArriveOnTheRightSide) {
  // All nodes, edges and faces of the octahedron lie on whole numbers, as do the ends of the paths.
  constexpr std::int64_t kSize = 4;
  const Triangles surface = Octahedron(kSize);
  const Place outside = {-7, 0, 0};
  int through_nodes = 0;
  for (std::int64_t x = -6; x <= 6; ++x) {
    for (std::int64_t y = -6; y <= 6; ++y) {
      for (std::int64_t z = -6; z <= 6; ++z) {
        const std::int64_t away = std::abs(x) + std::abs(y) + std::abs(z);
        const int inside = TurnsAlong(surface, outside, {x, y, z});
        if (away < kSize) {
          EXPECT_EQ(inside, 1) << x << " " << y << " " << z;
        }
        if (away > kSize) {
          EXPECT_EQ(inside, 0) << x << " " << y << " " << z;
        }
        // On the surface it is one or the other, from wherever one comes.
        EXPECT_TRUE(inside == 0 || inside == 1);
        for (const Place& from :
             {Place{9, 0, 0}, Place{0, -9, 0}, Place{5, 5, 5}, Place{0, 0, 7}}) {
          EXPECT_EQ(TurnsAlong(surface, from, {x, y, z}), inside) << x << " " << y << " " << z;
        }
        through_nodes += y == 0 && z == 0 ? 1 : 0;
      }
    }
  }
  EXPECT_EQ(through_nodes, 13);
}

TEST(ExactCrossing, ClosedPathsOfAnySizeCrossAClosedSurfaceAsOftenInAsOut) {
  std::mt19937_64 random(5);
  for (const std::int64_t reach : {std::int64_t{2}, std::int64_t{9}, kMaxPlace / 4, kMaxPlace}) {
    // Tetrahedra of few whole numbers are full of coincidences; those of large ones test for
    // overflow.
    const std::int64_t size = std::min(reach, kMaxNode);
    std::uniform_int_distribution<std::int64_t> node(-size, size);
    std::uniform_int_distribution<std::int64_t> place(-reach, reach);
    int crossings = 0;
    for (int n = 0; n < 20000; ++n) {
      std::array<Place, 4> t, path;
      for (Place& p : t) p = {node(random), node(random), node(random)};
      for (Place& p : path) p = {place(random), place(random), place(random)};
      for (const std::size_t p : {0, 2}) path[p] = {node(random), node(random), node(random)};
      const Triangles surface = {
          {t[0], t[1], t[2]}, {t[0], t[2], t[3]}, {t[0], t[3], t[1]}, {t[1], t[3], t[2]}};
      int sum = 0;
      for (std::size_t p = 0; p < 4; ++p) {
        const int turns = TurnsAlong(surface, path[p], path[(p + 1) % 4]);
        crossings += turns != 0 ? 1 : 0;
        sum += turns;
      }
      ASSERT_EQ(sum, 0) << reach << " " << n;
    }
    EXPECT_GT(crossings, 1000) << reach;
  }
}

TEST(ExactCrossing, BarelyMissedAndBarelyMetAreToldApart) {
  // Next to an edge of a large triangle, by a sideways distance of 1e-8 of its size: a determinant
  // in doubles has no certain sign there.
  constexpr std::int64_t kFar = kMaxNode;
  const Place a = {-kFar, -kFar + 1, 0}, b = {kFar, kFar, 1}, c = {kFar, -kFar, -kFar};
  int met = 0;
  for (std::int64_t n = -1000; n <= 1000; ++n) {
    // Both triangles at the edge a, b; together they are met once by any path between.
    SegmentCrossing out{};
    const Place from = {n, n + 1, kFar}, to = {n + 1, n, -kFar};
    const Place d = {-kFar, kFar, -kFar};
    const bool one = Crosses(from, to, a, b, c, out);
    const bool other = Crosses(from, to, b, a, d, out);
    EXPECT_NE(one, other) << n;
    met += one ? 1 : 0;
  }
  EXPECT_GT(met, 0);
}

}  // namespace
}  // namespace acus::tracing
