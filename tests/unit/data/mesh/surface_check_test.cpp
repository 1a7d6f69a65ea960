#include "acus/data/mesh/surface_check.h"

#include <chrono>
#include <gmock/gmock.h>

#include "shapes.h"

namespace acus::mesh {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Surface WithoutTriangles(const Surface& surface, int first, int count) {
  Surface out = surface;
  const Eigen::Index rest = surface.triangles.cols() - first - count;
  out.triangles.resize(3, surface.triangles.cols() - count);
  out.triangles << surface.triangles.leftCols(first), surface.triangles.rightCols(rest);
  return out;
}

/// A ring of `around` by `across` squares: Euler number 0.
Surface Torus(int around, int across) {
  Surface out;
  out.nodes_mm.resize(3, around * across);
  out.triangles.resize(3, 2 * around * across);
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around;
      const double v = 2 * std::numbers::pi * j / across;
      out.nodes_mm.col(i * across + j) << (3 + std::cos(v)) * std::cos(u),
          (3 + std::cos(v)) * std::sin(u), std::sin(v);
      const int a = i * across + j, b = (i + 1) % around * across + j;
      const int c = (i + 1) % around * across + (j + 1) % across, d = i * across + (j + 1) % across;
      out.triangles.col(2 * (i * across + j)) << a, b, c;
      out.triangles.col(2 * (i * across + j) + 1) << a, c, d;
    }
  }
  return out;
}

TEST(CheckSurface, FindsNothingWrongWithASphere) {
  const SurfaceReport report = CheckSurface(shapes::Icosphere(10.0, 3));
  EXPECT_TRUE(report.is_fit_for_meshing());
  EXPECT_THAT(report.Sentences(), IsEmpty());
  EXPECT_EQ(report.euler_number, 2);
  EXPECT_EQ(report.num_components, 1);
  EXPECT_NEAR(report.volume_mm3, 4.0 / 3.0 * std::numbers::pi * 1000.0, 0.02 * 4189.0);
}

TEST(CheckSurface, CountsHandlesAndPieces) {
  EXPECT_EQ(CheckSurface(Torus(24, 12)).euler_number, 0);
  EXPECT_TRUE(CheckSurface(Torus(24, 12)).is_fit_for_meshing());
  const SurfaceReport two =
      CheckSurface(shapes::Joined(shapes::Cube(), shapes::Cube(1.0, {3, 0, 0})));
  EXPECT_EQ(two.num_components, 2);
  EXPECT_EQ(two.euler_number, 4);
  EXPECT_TRUE(two.is_fit_for_meshing());
}

TEST(CheckSurface, ReportsEachDefectWithItsPlace) {
  const Surface cube = shapes::Cube();
  const SurfaceReport open = CheckSurface(WithoutTriangles(cube, 0, 1));
  EXPECT_EQ(open.open_edges.count, 3U);
  EXPECT_FALSE(open.is_fit_for_meshing());
  EXPECT_THAT(open.Sentences(), ElementsAre(HasSubstr("3 open edge(s)")));

  Surface flipped = cube;
  std::swap(flipped.triangles(0, 4), flipped.triangles(1, 4));
  EXPECT_EQ(CheckSurface(flipped).flipped_edges.count, 3U);

  for (int t = 0; t < cube.triangles.cols(); ++t) {
    Surface doubled = cube;
    doubled.triangles.conservativeResize(3, 13);
    doubled.triangles.col(12) = cube.triangles.col(t);
    EXPECT_EQ(CheckSurface(doubled).duplicate_triangles.count, 1U) << t;
    EXPECT_EQ(CheckSurface(doubled).crowded_edges.count, 3U) << t;
  }

  Surface loose = cube;
  loose.nodes_mm.conservativeResize(3, 10);
  loose.nodes_mm.col(8) << 9, 9, 9;
  loose.nodes_mm.col(9) = loose.nodes_mm.col(7);
  EXPECT_EQ(CheckSurface(loose).loose_nodes.count, 2U);
  EXPECT_EQ(CheckSurface(loose).duplicate_nodes.count, 1U);
  EXPECT_EQ(CheckSurface(loose).duplicate_nodes.first_mm, Eigen::Vector3d(1, 1, 1));

  Surface flat = cube;
  flat.triangles(2, 0) = flat.triangles(1, 0);
  EXPECT_EQ(CheckSurface(flat).flat_triangles.count, 1U);
  EXPECT_THAT(CheckSurface(Surface{}).Sentences(), ElementsAre(HasSubstr("no triangle")));
}

TEST(CheckSurface, SeesSheetsThatTouchInOneNode) {
  Surface touching = shapes::Joined(shapes::Cube(), shapes::Cube(1.0, {1, 1, 1}));
  for (int& n : touching.triangles.reshaped()) n = n == 8 ? 7 : n;  // The corner (1, 1, 1).
  const SurfaceReport report = CheckSurface(touching);
  EXPECT_EQ(report.crowded_nodes.count, 1U);
  EXPECT_EQ(report.crowded_nodes.first_mm, Eigen::Vector3d(1, 1, 1));
  EXPECT_EQ(report.crowded_edges.count, 0U);
}

TEST(CheckSurface, FindsSurfacesThatCutEachOther) {
  const SurfaceReport apart = CheckSurface(
      shapes::Joined(shapes::Icosphere(1.0, 2), shapes::Icosphere(1.0, 2, {2.1, 0, 0})));
  EXPECT_EQ(apart.intersections.count, 0U);
  const SurfaceReport through = CheckSurface(
      shapes::Joined(shapes::Icosphere(1.0, 2), shapes::Icosphere(1.0, 2, {1.0, 0.01, 0.02})));
  EXPECT_GT(through.intersections.count, 20U);
  EXPECT_NEAR(through.intersections.first_mm[0], 0.5, 0.2);
  EXPECT_THAT(through.Sentences(), Contains(HasSubstr("cut each other")));
  const SurfaceReport inside =
      CheckSurface(shapes::Joined(shapes::Icosphere(1.0, 2), shapes::Icosphere(0.5, 2)));
  EXPECT_EQ(inside.intersections.count, 0U);
}

TEST(CheckSurface, TakesLittleTimeForManyTriangles) {
  const Surface fine = shapes::Icosphere(100.0, 6);  // 81,920 triangles.
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(CheckSurface(fine).is_fit_for_meshing());
  // Comparing all pairs would take minutes; generous for loaded machines and sanitizers.
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST(RepairSurface, TurnsASoupOfFlippedTrianglesIntoACube) {
  const Surface cube = shapes::Cube(2.0);
  Surface soup;
  soup.nodes_mm.resize(3, 36);
  soup.triangles.resize(3, 12);
  for (int t = 0; t < 12; ++t) {
    for (int c = 0; c < 3; ++c) {
      soup.nodes_mm.col(3 * t + c) = cube.nodes_mm.col(cube.triangles(c, t));
      soup.triangles(c, t) = 3 * t + (t % 3 == 0 ? 2 - c : c);
    }
  }
  EXPECT_FALSE(CheckSurface(soup).is_fit_for_meshing());
  const Repair repair = RepairSurface(soup);
  EXPECT_TRUE(CheckSurface(repair.surface).is_fit_for_meshing());
  EXPECT_EQ(repair.surface.nodes_mm.cols(), 8);
  EXPECT_DOUBLE_EQ(SignedVolumeMm3(repair.surface), 8.0);
  EXPECT_THAT(repair.done, Contains(HasSubstr("28 node(s) joined")));
  EXPECT_THAT(repair.done, Contains(HasSubstr("4 triangle(s) turned")));
}

TEST(RepairSurface, ClosesHolesAndTurnsInsideOut) {
  Surface sphere = shapes::Icosphere(10.0, 3);
  const double volume = SignedVolumeMm3(sphere);
  sphere.triangles.row(0).swap(sphere.triangles.row(1));
  const Repair repair = RepairSurface(WithoutTriangles(sphere, 100, 4));
  EXPECT_TRUE(CheckSurface(repair.surface).is_fit_for_meshing());
  EXPECT_NEAR(SignedVolumeMm3(repair.surface), volume, 0.01 * volume);
  EXPECT_THAT(repair.done, Contains(HasSubstr("face outwards")));
  RepairLimits none;
  none.longest_hole = 2;
  EXPECT_FALSE(
      CheckSurface(RepairSurface(WithoutTriangles(sphere, 100, 4), none).surface).is_closed());
}

TEST(RepairSurface, SmoothsASmallFold) {
  Surface sphere = shapes::Icosphere(10.0, 4);
  const int moved = sphere.triangles(0, 700);
  const Eigen::Vector3d over = sphere.nodes_mm.col(sphere.triangles(1, 700));
  sphere.nodes_mm.col(moved) += 1.9 * (over - sphere.nodes_mm.col(moved));
  ASSERT_GT(CheckSurface(sphere).intersections.count, 0U);
  const Repair repair = RepairSurface(sphere);
  EXPECT_TRUE(CheckSurface(repair.surface).is_fit_for_meshing());
}

TEST(RepairSurface, LeavesAGoodSurfaceAlone) {
  const Surface sphere = shapes::Icosphere(10.0, 2);
  const Repair repair = RepairSurface(sphere);
  EXPECT_THAT(repair.done, IsEmpty());
  EXPECT_EQ(repair.surface.nodes_mm, sphere.nodes_mm);
  EXPECT_EQ(repair.surface.triangles, sphere.triangles);
}

}  // namespace
}  // namespace acus::mesh
