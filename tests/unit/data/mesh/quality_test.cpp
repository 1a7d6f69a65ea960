#include "acus/data/mesh/quality.h"

#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "shapes.h"

namespace acus::mesh {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

const Corners kRegular = {Eigen::Vector3d(1, 1, 1), Eigen::Vector3d(-1, 1, -1),
                          Eigen::Vector3d(1, -1, -1), Eigen::Vector3d(-1, -1, 1)};
const Corners kCubeCorner = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1, 0, 0),
                             Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)};

TEST(RegularTetrahedron, HasItsKnownAnglesVolumeAndRatio) {
  EXPECT_NEAR(VolumeMm3(kRegular), 8.0 / 3.0, 1e-14);  // Edge sqrt(8): a^3 / (6 sqrt 2).
  for (const double angle : DihedralAnglesRad(kRegular))
    EXPECT_NEAR(angle, std::acos(1.0 / 3.0), 1e-14);
  EXPECT_NEAR(RadiusEdgeRatio(kRegular), std::sqrt(6.0) / 4.0, 1e-14);
  EXPECT_NEAR(DihedralScore(kRegular), -1.0 / 3.0, 1e-14);
}

TEST(CubeCorner, HasThreeRightAnglesAndThreeOfAtanRoot2) {
  const auto angles = DihedralAnglesRad(kCubeCorner);
  for (int e = 0; e < 3; ++e) EXPECT_NEAR(angles[e] * kDegrees, 90.0, 1e-12);
  for (int e = 3; e < 6; ++e) EXPECT_NEAR(angles[e], std::atan(std::sqrt(2.0)), 1e-14);
  EXPECT_NEAR(VolumeMm3(kCubeCorner), 1.0 / 6.0, 1e-15);
  EXPECT_NEAR(RadiusEdgeRatio(kCubeCorner), std::sqrt(3.0) / 2.0, 1e-14);
}

TEST(DihedralScore, IsMinusTheCosineOfTheSmallestAngle) {
  for (const double height : {0.01, 0.1, 0.5, 2.0, 10.0}) {
    Corners x = kCubeCorner;
    x[3] = {0.3, 0.3, height};
    double least = 4.0;
    for (const double angle : DihedralAnglesRad(x)) least = std::min(least, angle);
    EXPECT_NEAR(DegreesOfScore(DihedralScore(x)), least * kDegrees, 1e-9);
    EXPECT_NEAR(ScoreOfDegrees(least * kDegrees), DihedralScore(x), 1e-12);
  }
}

TEST(DihedralScore, DoesNotChangeWithScaleOrPlace) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Corners x = kCubeCorner;
    for (auto& p : x) p = scale * (p + Eigen::Vector3d(3, -2, 7));
    EXPECT_NEAR(DihedralScore(x), DihedralScore(kCubeCorner), 1e-9);
  }
}

TEST(DihedralScore, PutsFlatAndInvertedLast) {
  Corners inverted = kRegular;
  std::swap(inverted[0], inverted[1]);
  EXPECT_EQ(DihedralScore(inverted), -2.0);
  Corners flat = kCubeCorner;
  flat[3] = {0.5, 0.5, 0.0};
  EXPECT_EQ(DihedralScore(flat), -2.0);
  EXPECT_LT(-2.0, ScoreOfDegrees(0.001));
}

TEST(MeasureQuality, CountsNodesAnglesAndInvertedElements) {
  TetraMesh mesh = shapes::TwoTetrahedra();
  QualityReport report = MeasureQuality(mesh);
  EXPECT_EQ(report.num_nodes, 5);
  EXPECT_EQ(report.num_fixed_nodes, 1);
  EXPECT_EQ(report.num_inverted, 0);
  EXPECT_NEAR(report.min_dihedral_deg, std::atan(std::sqrt(2.0)) * kDegrees, 1e-9);
  Eigen::Index angles = 0;
  for (const Eigen::Index count : report.histogram) angles += count;
  EXPECT_EQ(angles, 12);
  std::swap(mesh.tetrahedra(0, 0), mesh.tetrahedra(1, 0));
  report = MeasureQuality(mesh);
  EXPECT_EQ(report.num_inverted, 1);
}

}  // namespace
}  // namespace acus::mesh
