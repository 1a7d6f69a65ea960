#include "benchmarks/tissue_block.h"

#include <array>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/data/mesh/quality.h"
#include "acus/data/volume/labels.h"

namespace acus::benchmarks {
namespace {

class BlockMesh : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Sizes, BlockMesh, testing::Values(12.0, 6.0, 4.0, 3.0));

TEST_P(BlockMesh, FillsTheLayersExactly) {
  const mesh::TetraMesh mesh = TissueBlock::Mesh(GetParam());
  std::array<double, 256> volume_mm3{};
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    const double volume = mesh::VolumeMm3(mesh::CornersOf(mesh, t));
    ASSERT_GT(volume, 0.0);
    volume_mm3[mesh.tissue[static_cast<std::size_t>(t)]] += volume;
  }
  const double area_mm2 = 4.0 * TissueBlock::kHalfWidthMm * TissueBlock::kHalfWidthMm;
  const auto thick_mm = [&](const char* name) {
    return volume_mm3[volume::LabelOf(name)] / area_mm2;
  };
  EXPECT_NEAR(thick_mm("skin"), 4.0, 1e-9);
  EXPECT_NEAR(thick_mm("fat"), 16.0, 1e-9);
  EXPECT_NEAR(thick_mm("muscle"), 16.0, 1e-9);
  EXPECT_NEAR(thick_mm("liver"), 164.0, 1e-9);
}

TEST_P(BlockMesh, IsAsFineAsRequestedAroundTheAxisAndFixedAtTheBottom) {
  const mesh::TetraMesh mesh = TissueBlock::Mesh(GetParam());
  double nearest_mm = 1e300;
  for (Eigen::Index n = 0; n < mesh.nodes_mm.cols(); ++n) {
    const Eigen::Vector3d x = mesh.nodes_mm.col(n);
    EXPECT_EQ(mesh.fixed_nodes[static_cast<std::size_t>(n)] != 0, x[2] == -TissueBlock::kDepthMm);
    if (x.norm() > 0.0 && x[2] == 0.0) nearest_mm = std::min(nearest_mm, x.norm());
  }
  EXPECT_NEAR(nearest_mm, GetParam(), 1e-9);
}

TEST(TissueBlock, ReportsItsTissues) {
  const auto at = [](double x, double y, double depth) {
    return std::string(volume::StandardLabels()[TissueBlock::TissueAt({x, y, -depth})].name);
  };
  EXPECT_EQ(at(0, 0, 2), "skin");
  EXPECT_EQ(at(0, 0, 10), "fat");
  EXPECT_EQ(at(-150, 150, 30), "muscle");
  EXPECT_EQ(at(0, 0, 60), "liver");
  EXPECT_EQ(at(0, 0, -0.1), "outside");
  EXPECT_EQ(at(161, 0, 10), "outside");
  EXPECT_EQ(at(0, 0, 201), "outside");
}

TEST(SquarePressure, AgreesWithKnownPlacesAndWithAPointFarAway) {
  const mechanics::ElasticTissue tissue{0.01, 0.3};
  const double half = 5.0;
  const double factor = (1.0 - 0.09) / (std::numbers::pi * 0.01);
  // Timoshenko & Goodier, art. 139: 1.122 p b (1 - nu^2) / E in the middle, half of it at a corner.
  const double middle = SquarePressureMmPerN(tissue, half, 0.0, 0.0);
  EXPECT_NEAR(middle, 1.122 * (1.0 / 100.0) * 10.0 * 0.91 / 0.01, 0.001 * middle);
  EXPECT_NEAR(SquarePressureMmPerN(tissue, half, half, half), 0.5 * middle, 1e-9 * middle);
  EXPECT_NEAR(SquarePressureMmPerN(tissue, half, 300.0, 0.0), factor / 300.0,
              1e-4 * factor / 300.0);
}

}  // namespace
}  // namespace acus::benchmarks
