#include "acus/patient/breathing_registration/lung_density.h"

#include <gmock/gmock.h>

#include "acus/patient/breathing_registration/level_image.h"

namespace acus::breathing_registration {
namespace {

using Eigen::Vector3f;

volume::Geometry LungCube() {
  volume::Geometry g;
  g.size = {16, 16, 16};
  g.spacing_mm.setConstant(3.0);
  return g;
}

SlidingGrid LungNodes() {
  const volume::Geometry g = LungCube();
  return {g, std::vector(g.num_voxels(), Side::kCavity),
          std::vector<Vector3f>(g.num_voxels(), Vector3f::Zero())};
}

/// Lung of that HU below z = 8, tissue of 40 HU above.
ModelImage LungUnderTissue(double lung_hu) {
  volume::Grid<float> image(LungCube());
  for (std::size_t v = 0; v < image.voxels.size(); ++v) {
    image.voxels[v] = static_cast<float>(Contrast(v / 256 < 8 ? lung_hu : 40.0));
  }
  return {image, 1};
}

int NodeOfLung(const SlidingGrid& grid, int z) {
  return grid.NodeAt(grid.geometry().Index(8, 8, z));
}

TEST(LungDensity, IsTheRatioOfMasses) {
  const SlidingGrid grid = LungNodes();
  const SlidingGrid::Field at_rest(static_cast<std::size_t>(grid.num_nodes()), Vector3f::Zero());
  // Compressed to three quarters of its volume: 200 HU above air become 266.7.
  const LungDensity density(grid, at_rest, LungUnderTissue(-800.0),
                            LungUnderTissue(-1000.0 + 200.0 / 0.75), 1);
  const int lung = NodeOfLung(grid, 3);
  EXPECT_NEAR(density.VolumeRatio(lung), 0.75, 1e-4);
  const auto look = density.At(lung, static_cast<float>(Contrast(-800.0)));
  EXPECT_NEAR(look.contrast, Contrast(-1000.0 + 200.0 / 0.75), 1e-2);
  EXPECT_NEAR(look.slope, 1.0 / 0.75, 1e-3);
}

TEST(LungDensity, LeavesTissueAsItIs) {
  const SlidingGrid grid = LungNodes();
  const SlidingGrid::Field at_rest(static_cast<std::size_t>(grid.num_nodes()), Vector3f::Zero());
  const LungDensity density(grid, at_rest, LungUnderTissue(-800.0), LungUnderTissue(-700.0), 1);
  const int tissue = NodeOfLung(grid, 14);
  EXPECT_EQ(density.VolumeRatio(tissue), 1.0F);
  EXPECT_EQ(density.At(tissue, 40.0F).contrast, 40.0F);
  // A node of lung beside the tissue: what it looks like falls to the tissue's without a step.
  const int lung = NodeOfLung(grid, 7);
  EXPECT_NEAR(density.At(lung, -225.001F).contrast, density.At(lung, -224.999F).contrast, 0.01);
  EXPECT_NEAR(density.At(lung, 49.999F).contrast, 50.0F, 0.01);
  EXPECT_NEAR(density.At(lung, -400.0F).contrast, -400.0F, 0.01);
}

TEST(LungDensity, IsNotMisledByATissueThatMovedIn) {
  const SlidingGrid grid = LungNodes();
  // The field takes all eight nodes up, so that lung is compared with tissue: no ratio.
  const SlidingGrid::Field up(static_cast<std::size_t>(grid.num_nodes()), Vector3f(0, 0, 8));
  const ModelImage image = LungUnderTissue(-800.0);
  const LungDensity density(grid, up, image, image, 1);
  EXPECT_EQ(density.VolumeRatio(NodeOfLung(grid, 4)), 1.0F);
}

TEST(LungDensity, IsTheSameWithAnyNumberOfThreads) {
  const SlidingGrid grid = LungNodes();
  SlidingGrid::Field u(static_cast<std::size_t>(grid.num_nodes()));
  for (std::size_t n = 0; n < u.size(); ++n) u[n].z() = 0.3F * static_cast<float>(n % 5);
  const ModelImage reference = LungUnderTissue(-850.0), phase = LungUnderTissue(-760.0);
  const LungDensity one(grid, u, reference, phase, 1), four(grid, u, reference, phase, 4);
  for (int n = 0; n < grid.num_nodes(); ++n) ASSERT_EQ(one.VolumeRatio(n), four.VolumeRatio(n));
}

}  // namespace
}  // namespace acus::breathing_registration
