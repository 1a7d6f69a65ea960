#include "acus/patient/breathing_registration/sliding_grid.h"

#include <cmath>
#include <gmock/gmock.h>

namespace acus::breathing_registration {
namespace {

using Eigen::Vector3f;

/// 12^3 nodes, wall at z = 6 with the normal along z.
SlidingGrid TwoHalves() {
  volume::Geometry g;
  g.size = {12, 12, 12};
  std::vector<Side> side(g.num_voxels());
  for (std::size_t v = 0; v < side.size(); ++v) {
    side[v] = v / 144 < 6 ? Side::kCavity : Side::kWall;
  }
  return {g, side, std::vector<Vector3f>(g.num_voxels(), Vector3f::UnitZ())};
}

/// Strong data for one displacement in the cavity; none in the wall.
DataTerm DataInCavity(const SlidingGrid& grid, const Vector3f& displacement, int axis) {
  DataTerm data{
      .gradient = SlidingGrid::Field(static_cast<std::size_t>(grid.num_nodes()), Vector3f::Zero()),
      .force = {}};
  data.force = data.gradient;
  for (int n = 0; n < grid.num_nodes(); ++n) {
    if (grid.SideOf(n) != Side::kCavity) continue;
    const auto i = static_cast<std::size_t>(n);
    data.gradient[i] = 10.0F * Vector3f::Unit(axis);
    data.force[i] = 100.0F * displacement[axis] * Vector3f::Unit(axis);
  }
  return data;
}

TEST(SlidingGrid, TissueSlidesAlongTheWallButDoesNotLeaveIt) {
  const SlidingGrid grid = TwoHalves();
  DataTerm data = DataInCavity(grid, {1, 0, 0}, 0);
  for (int n = 0; n < grid.num_nodes(); ++n) {  // The outermost layer of the wall stays.
    if (grid.Voxel(n) / 144 == 11) data.gradient[static_cast<std::size_t>(n)] = {10, 0, 0};
  }
  const auto along = SolveStep(grid, data, 1.0F, 400, 1);
  const auto away = SolveStep(grid, DataInCavity(grid, {0, 0, 1}, 2), 1.0F, 400, 1);
  for (int n = 0; n < grid.num_nodes(); ++n) {
    const auto i = static_cast<std::size_t>(n);
    EXPECT_NEAR(along[i].x(), grid.SideOf(n) == Side::kCavity ? 1.0 : 0.0, 1e-2);
    EXPECT_NEAR(away[i].z(), 1.0, 1e-2);
  }
}

/// A body that fills the grid to its border, squeezed by `gradient` everywhere.
SlidingGrid::Field Affine(const SlidingGrid& grid, const Eigen::Matrix3f& gradient) {
  SlidingGrid::Field u;
  for (int n = 0; n < grid.num_nodes(); ++n) {
    u.push_back((gradient - Eigen::Matrix3f::Identity()) * grid.IndexOf(n));
  }
  return u;
}

TEST(SlidingGrid, TheDeterminantIsThatOfTheMotionUpToTheBorder) {
  const SlidingGrid grid = TwoHalves();
  Eigen::Matrix3f gradient;
  gradient << 0.9F, 0.2F, 0.0F, -0.1F, 1.1F, 0.1F, 0.0F, 0.05F, 0.8F;
  EXPECT_NEAR(grid.SmallestDeterminant(Affine(grid, gradient)).value(),
              static_cast<double>(gradient.determinant()), 1e-5);
  const Eigen::Matrix3f wider = 1.3F * Eigen::Matrix3f::Identity();
  EXPECT_NEAR(grid.SmallestDeterminant(Affine(grid, wider)).value(), std::pow(1.3, 3), 1e-5);
}

TEST(SlidingGrid, AFoldIsSeenAndSlidingIsNone) {
  const SlidingGrid grid = TwoHalves();
  SlidingGrid::Field u(static_cast<std::size_t>(grid.num_nodes()), Vector3f::Zero());
  for (int n = 0; n < grid.num_nodes(); ++n) {
    if (grid.SideOf(n) == Side::kCavity) u[static_cast<std::size_t>(n)] = {5, 3, 0};
  }
  EXPECT_EQ(grid.SmallestDeterminant(u).value(), 1.0);
  u[static_cast<std::size_t>(grid.NodeAt(5 + 12 * (5 + 12 * 2)))].x() -= 1.5F;
  EXPECT_NEAR(grid.SmallestDeterminant(u).value(), -0.5, 1e-6);
}

TEST(SlidingGrid, ALayerOfOneNodeHasNoDeterminant) {
  volume::Geometry g;
  g.size = {4, 4, 1};
  const SlidingGrid grid(g, std::vector<Side>(16, Side::kWall),
                         std::vector<Vector3f>(16, Vector3f::UnitZ()));
  EXPECT_FALSE(grid.SmallestDeterminant(SlidingGrid::Field(16, Vector3f::Zero())));
}

/// Nodes that the other side surrounds are tied along one normal only; with steep images beside
/// them, their blocks are near singular.
TEST(SlidingGrid, SolvesWithIslandsOfOneNode) {
  volume::Geometry g;
  g.size = {12, 12, 12};
  std::vector<Side> side(g.num_voxels(), Side::kWall);
  for (std::size_t v = 0; v < side.size(); v += 5) side[v] = Side::kCavity;
  const std::vector<Vector3f> normal(g.num_voxels(), Vector3f(1, 2, 3).normalized());
  const SlidingGrid grid(g, side, normal);
  DataTerm data{.gradient = SlidingGrid::Field(side.size()), .force = {}};
  data.force.resize(side.size());
  for (int n = 0; n < grid.num_nodes(); ++n) {
    const auto i = static_cast<std::size_t>(n);
    const auto angle = static_cast<float>(n);
    data.gradient[i] =
        10.0F * Vector3f(std::sin(angle), std::sin(2.0F * angle), std::sin(3.0F * angle));
    data.force[i] = data.gradient[i];
  }
  const auto u = SolveStep(grid, data, 1.0F, 400, 1);
  double left = 0.0, all = 0.0;
  for (int n = 0; n < grid.num_nodes(); ++n) {
    const auto i = static_cast<std::size_t>(n);
    const Vector3f& slope = data.gradient[i];
    const Vector3f rest = data.force[i] - slope * slope.dot(u[i]) - grid.Pull(u, n) - 1e-4F * u[i];
    left += static_cast<double>(rest.squaredNorm());
    all += static_cast<double>(data.force[i].squaredNorm());
  }
  EXPECT_LT(std::sqrt(left / all), 1e-3);
}

TEST(SlidingGrid, AUniformFieldCostsNothing) {
  const SlidingGrid grid = TwoHalves();
  const SlidingGrid::Field u(static_cast<std::size_t>(grid.num_nodes()), Vector3f(1, 2, 3));
  for (int n = 0; n < grid.num_nodes(); ++n) EXPECT_EQ(grid.Pull(u, n), Vector3f::Zero());
}

TEST(SlidingGrid, ReadsOneSideOnly) {
  const SlidingGrid grid = TwoHalves();
  SlidingGrid::Field u(static_cast<std::size_t>(grid.num_nodes()));
  for (int n = 0; n < grid.num_nodes(); ++n) {
    u[static_cast<std::size_t>(n)] =
        grid.SideOf(n) == Side::kCavity ? Vector3f(5, 0, 0) : Vector3f(-1, 0, 0);
  }
  const Vector3f between(4.3F, 4.6F, 5.5F);
  EXPECT_NEAR(grid.At(u, between, Side::kCavity).x(), 5.0, 1e-5);
  EXPECT_NEAR(grid.At(u, between, Side::kWall).x(), -1.0, 1e-5);
}

TEST(SlidingGrid, BeyondTissueAsTheNearestOfIt) {
  volume::Geometry g;
  g.size = {9, 9, 9};
  std::vector<Side> side(g.num_voxels(), Side::kNone);
  side[g.Index(4, 4, 4)] = Side::kWall;
  const SlidingGrid grid(g, side, std::vector<Vector3f>(g.num_voxels(), Vector3f::Zero()));
  for (const Vector3f& u : grid.Everywhere({Vector3f(1, 2, 3)})) EXPECT_EQ(u, Vector3f(1, 2, 3));
}

// Sums run over 8192 nodes at a time: here one is left over.
TEST(SlidingGrid, EveryNodeOfALongRowIsSolved) {
  volume::Geometry g;
  g.size = {3, 2731, 1};
  const SlidingGrid grid(g, std::vector(g.num_voxels(), Side::kWall),
                         std::vector<Vector3f>(g.num_voxels(), Vector3f::Zero()));
  const auto count = static_cast<std::size_t>(grid.num_nodes());
  ASSERT_EQ(count, 8193u);
  DataTerm data{.gradient = SlidingGrid::Field(count, Vector3f(10, 0, 0)),
                .force = SlidingGrid::Field(count, Vector3f(100, 0, 0))};
  const SlidingGrid::Field step = SolveStep(grid, data, 1.0F, 20, 1);
  for (std::size_t n = 0; n < count; ++n) EXPECT_NEAR(step[n].x(), 1.0F, 1e-3F) << n;
}

TEST(SlidingGrid, SolvesTheSameOnAnyThreads) {
  const SlidingGrid grid = TwoHalves();
  const DataTerm data = DataInCavity(grid, {1, 0, 0}, 0);
  EXPECT_EQ(SolveStep(grid, data, 0.3F, 20, 1), SolveStep(grid, data, 0.3F, 20, 4));
}

}  // namespace
}  // namespace acus::breathing_registration
