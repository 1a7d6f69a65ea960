#include "acus/patient/meshing/surface_distance.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>

#include "acus/data/mesh/quality.h"
#include "label_maps.h"

namespace acus::meshing {
namespace {

using label_maps::kBone;
using label_maps::kFat;

/// A box of tetrahedra: six around the diagonal of each of n x n x n bricks. Bone where x <
/// split_mm.
mesh::TetraMesh SurfaceDistanceBox(const Eigen::Vector3d& low, const Eigen::Vector3d& high,
                                   double split_mm) {
  constexpr int kN = 8;
  mesh::TetraMesh out;
  const auto number = [](const Eigen::Vector3i& p) {
    return (p[2] * (kN + 1) + p[1]) * (kN + 1) + p[0];
  };
  out.nodes_mm.resize(3, (kN + 1) * (kN + 1) * (kN + 1));
  out.tetrahedra.resize(4, 6 * kN * kN * kN);
  Eigen::Vector3i p;
  for (p[2] = 0; p[2] <= kN; ++p[2]) {
    for (p[1] = 0; p[1] <= kN; ++p[1]) {
      for (p[0] = 0; p[0] <= kN; ++p[0]) {
        out.nodes_mm.col(number(p)) = low + (high - low).cwiseProduct(p.cast<double>() / kN);
      }
    }
  }
  const std::array<std::array<int, 3>, 6> orders = {
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  int count = 0;
  for (p[2] = 0; p[2] < kN; ++p[2]) {
    for (p[1] = 0; p[1] < kN; ++p[1]) {
      for (p[0] = 0; p[0] < kN; ++p[0]) {
        for (const auto& order : orders) {
          Eigen::Vector3i corner = p;
          Eigen::Vector4i tetrahedron(number(corner), 0, 0, 0);
          for (int c = 0; c < 3; ++c) {
            ++corner[order[c]];
            tetrahedron[c + 1] = number(corner);
          }
          out.tetrahedra.col(count++) = tetrahedron;
          const double x = low[0] + (high[0] - low[0]) * (p[0] + 0.5) / kN;
          out.tissue.push_back(x < split_mm ? kBone : kFat);
        }
      }
    }
  }
  return out;
}

/// A box of 20 x 24 x 28 mm in voxels of 1 x 1 x 2 mm, bone below x = 0; outside around it.
volume::LabelMap BoxMap() {
  volume::Geometry g;
  g.size = {40, 40, 24};
  g.spacing_mm = {1.0, 1.0, 2.0};
  g.origin_mm = {-19.5, -19.5, -23.0};
  volume::LabelMap out(g);
  for (int k = 0; k < 24; ++k) {
    for (int j = 0; j < 40; ++j) {
      for (int i = 0; i < 40; ++i) {
        const Eigen::Vector3d x =
            g.origin_mm + Eigen::Vector3d(i, j, k).cwiseProduct(g.spacing_mm.matrix());
        const bool is_inside =
            std::abs(x[0]) < 10.0 && std::abs(x[1]) < 12.0 && std::abs(x[2]) < 14.0;
        out.At(i, j, k) = !is_inside ? 0 : x[0] < 0.0 ? kBone : kFat;
      }
    }
  }
  return out;
}

const Eigen::Vector3d kHalf(10, 12, 14);

TEST(SurfaceDistance, IsZeroForTheVeryBoundary) {
  const auto all = MeasureSurfaceDistances(BoxMap(), SurfaceDistanceBox(-kHalf, kHalf, 0.0), 2);
  ASSERT_EQ(all.size(), 3U);
  EXPECT_EQ(all[0].label, 0);
  EXPECT_EQ(all[1].label, kFat);
  EXPECT_EQ(all[2].label, kBone);
  for (const SurfaceDistance& d : all) {
    EXPECT_NEAR(d.p95_mm, 0.0, 1e-9);
    EXPECT_NEAR(d.mean_mm, 0.0, 1e-9);
    EXPECT_NEAR(d.p95_voxels, 0.0, 1e-9);
    EXPECT_GT(d.num_samples, 3000U);
  }
}

TEST(SurfaceDistance, IsHowFarABoxWasMoved) {
  // Moved along z by 1.5 mm: faces at z are 1.5 mm off, and only the rims of the others.
  const Eigen::Vector3d shift(0, 0, 1.5);
  const auto along =
      MeasureSurfaceDistances(BoxMap(), SurfaceDistanceBox(shift - kHalf, shift + kHalf, 0.0), 1);
  EXPECT_NEAR(along[0].p95_mm, 1.5, 1e-9);
  EXPECT_NEAR(along[0].p95_voxels, 0.75, 1e-9);  // Slices are 2 mm apart.
  const Eigen::Vector3d grown = kHalf + Eigen::Vector3d(0.5, 0.5, 0.5);
  const auto around = MeasureSurfaceDistances(BoxMap(), SurfaceDistanceBox(-grown, grown, 0.0), 1);
  EXPECT_NEAR(around[0].p95_mm, 0.5, 0.1);  // More at the edges of the box.
  EXPECT_NEAR(around[0].mean_mm, 0.5, 0.02);
  EXPECT_NEAR(around[0].p95_voxels, 0.5, 0.1);
}

TEST(SurfaceDistance, SeesWhatOneSideLacks) {
  // No bone in the mesh: infinitely far. A cavity that the mesh fills: far, seen from the map only.
  const auto all = MeasureSurfaceDistances(BoxMap(), SurfaceDistanceBox(-kHalf, kHalf, -100.0), 1);
  EXPECT_TRUE(std::isinf(all[2].p95_mm));
  EXPECT_NEAR(all[1].p95_mm, 10.0, 0.5);
  volume::LabelMap hollow = BoxMap();
  for (volume::Label& label : hollow.voxels) label = label == kBone ? 0 : label;
  const auto filled = MeasureSurfaceDistances(hollow, SurfaceDistanceBox(-kHalf, kHalf, -100.0), 1);
  EXPECT_GT(filled[0].p95_mm, 8.0);
}

TEST(SurfaceDistance, IsTheSameForTurnedVolumes) {
  volume::LabelMap map = BoxMap();
  mesh::TetraMesh mesh = SurfaceDistanceBox(-kHalf, 1.05 * kHalf, 0.0);
  const auto straight = MeasureSurfaceDistances(map, mesh, 1);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Eigen::Vector3d(3, -1, 2).normalized()).matrix();
  map.geometry.direction = turn;
  map.geometry.origin_mm = turn * map.geometry.origin_mm + Eigen::Vector3d(5, 6, 7);
  mesh.nodes_mm = (turn * mesh.nodes_mm).colwise() + Eigen::Vector3d(5, 6, 7);
  const auto turned = MeasureSurfaceDistances(map, mesh, 1);
  for (std::size_t n = 0; n < straight.size(); ++n) {
    EXPECT_NEAR(turned[n].p95_mm, straight[n].p95_mm, 1e-9);
    EXPECT_NEAR(turned[n].p95_voxels, straight[n].p95_voxels, 1e-9);
  }
}

}  // namespace
}  // namespace acus::meshing
