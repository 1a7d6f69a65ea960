#include "acus/patient/breathing_registration/entered_tissue.h"

#include <gmock/gmock.h>

#include "acus/patient/breathing_registration/error_bound.h"

namespace acus::breathing_registration {
namespace {

using Eigen::Vector3f;

SlidingGrid WholeCube(int size) {
  volume::Geometry g;
  g.size = {size, size, size};
  g.spacing_mm.setConstant(2.0);
  return {g, std::vector(g.num_voxels(), Side::kWall),
          std::vector<Vector3f>(g.num_voxels(), Vector3f::Zero())};
}

SlidingGrid::Field Uniform(const SlidingGrid& grid, const Vector3f& u) {
  return SlidingGrid::Field(static_cast<std::size_t>(grid.num_nodes()), u);
}

TEST(EnteredTissue, IsAsDeepAsTheTissueMovedIn) {
  const SlidingGrid grid = WholeCube(16);
  const EnteredTissue entered(grid, Uniform(grid, {0, 0, -5}));  // From the high face of z.
  EXPECT_TRUE(entered.Holds({8, 8, 15}));
  EXPECT_TRUE(entered.Holds({8, 8, 11}));
  EXPECT_FALSE(entered.Holds({8, 8, 8}));
  EXPECT_FALSE(entered.Holds({8, 8, 0}));
  EXPECT_FALSE(entered.Holds({0, 15, 4}));
}

TEST(EnteredTissue, IsNowhereIfNothingMoves) {
  const SlidingGrid grid = WholeCube(8);
  const EnteredTissue entered(grid, Uniform(grid, {0, 0, 0}));
  EXPECT_FALSE(entered.Holds({0, 0, 0}));
  EXPECT_FALSE(entered.Holds({7, 7, 7}));
}

TEST(EnteredTissue, MayBeAnywhereNearTheBorderBeforeMotionIsKnown) {
  const SlidingGrid grid = WholeCube(16);
  const EnteredTissue entered(grid, 4.0F);
  EXPECT_TRUE(entered.Holds({2, 8, 8}));
  EXPECT_TRUE(entered.Holds({8, 13, 8}));
  EXPECT_FALSE(entered.Holds({8, 8, 8}));
}

/// A field that is stretched along z; what lies above `seen_to` has no match.
ErrorBound BoundOfStretched(const SlidingGrid& grid, int seen_to) {
  Solution solution{
      .displacement_voxels = Uniform(grid, Vector3f::Zero()),
      .coarser_voxels = {},
      .is_seen = {},
      .wall_mm = std::vector<float>(static_cast<std::size_t>(grid.num_nodes()), 1e6F)};
  for (int n = 0; n < grid.num_nodes(); ++n) {
    const auto z = static_cast<float>(grid.Voxel(n) / 1024);
    solution.displacement_voxels[static_cast<std::size_t>(n)].z() = 0.1F * z;
    solution.is_seen.push_back(z <= static_cast<float>(seen_to) ? 1 : 0);
  }
  solution.coarser_voxels = solution.displacement_voxels;
  return {grid, solution, 1};
}

TEST(ErrorBound, GrowsWithTheDistanceToWhatIsSeen) {
  const SlidingGrid grid = WholeCube(32);
  const ErrorBound whole = BoundOfStretched(grid, 31), part = BoundOfStretched(grid, 15);
  EXPECT_EQ(whole.unseen_share(), 0.0);
  EXPECT_NEAR(part.unseen_share(), 0.5, 1e-9);
  // 1.3 nodes of 2 mm at a strain of 0.1.
  EXPECT_NEAR(whole.Mm({16, 16, 16}, Side::kWall), 1.3 * 2.0 * 0.1, 0.01);
  EXPECT_NEAR(part.Mm({16, 16, 8}, Side::kWall), whole.Mm({16, 16, 8}, Side::kWall), 1e-6);
  EXPECT_GT(part.Mm({16, 16, 22}, Side::kWall), 2.0 * whole.Mm({16, 16, 22}, Side::kWall));
  EXPECT_GT(part.Mm({16, 16, 30}, Side::kWall), part.Mm({16, 16, 20}, Side::kWall));
  EXPECT_TRUE(part.IsUnseen({16, 16, 28}, Side::kWall));
  EXPECT_FALSE(part.IsUnseen({16, 16, 4}, Side::kWall));
  EXPECT_EQ(part.Mm({16, 16, 8}, Side::kCavity), 0.0);
}

/// At rest; the next coarser grid had found it elsewhere where z is from `first` to `last`.
ErrorBound BoundOfDoubt(const SlidingGrid& grid, int first, int last) {
  const auto count = static_cast<std::size_t>(grid.num_nodes());
  Solution solution{.displacement_voxels = Uniform(grid, Vector3f::Zero()),
                    .coarser_voxels = Uniform(grid, Vector3f::Zero()),
                    .is_seen = std::vector<std::uint8_t>(count, 1),
                    .wall_mm = std::vector<float>(count, 1e6F)};
  for (int n = 0; n < grid.num_nodes(); ++n) {
    const auto z = static_cast<int>(grid.Voxel(n) / 1024);
    if (z >= first && z <= last) {
      solution.coarser_voxels[static_cast<std::size_t>(n)] = Vector3f::UnitX();
    }
  }
  return {grid, solution, 1};
}

TEST(ErrorBound, IsTheSameFromBothEnds) {
  const SlidingGrid grid = WholeCube(32);
  const ErrorBound low = BoundOfDoubt(grid, 0, 11), high = BoundOfDoubt(grid, 20, 31);
  // 0.42 times a voxel of 2 mm in the middle of the doubt, hardly anything far from it.
  EXPECT_NEAR(low.Mm({16, 16, 2}, Side::kWall), 0.84, 0.05);
  EXPECT_NEAR(low.Mm({16, 16, 28}, Side::kWall), 0.05, 0.01);
  for (int z = 0; z < 32; ++z) {
    const auto at = static_cast<float>(z);
    EXPECT_NEAR(low.Mm({16, 16, at}, Side::kWall), high.Mm({16, 16, 31 - at}, Side::kWall), 1e-3)
        << z;
  }
}

}  // namespace
}  // namespace acus::breathing_registration
