#include "acus/data/mesh/point_location.h"

#include <gtest/gtest.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"
#include "acus/data/mesh/quality.h"
#include "shapes.h"

namespace acus::mesh {
namespace {

/// n^3 cubes of six tetrahedra each (Kuhn), over [0, n]^3.
TetraMesh Cubes(int n) {
  TetraMesh out;
  const int side = n + 1;
  out.nodes_mm.resize(3, side * side * side);
  for (int i = 0; i < out.nodes_mm.cols(); ++i) {
    out.nodes_mm.col(i) << i % side, i / side % side, i / (side * side);
  }
  const int orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}};
  const int steps[3] = {1, side, side * side};
  std::vector<Eigen::Vector4i> tetrahedra;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        for (int o = 0; o < 6; ++o) {
          Eigen::Vector4i t;
          t[0] = i + side * (j + side * k);
          for (int s = 0; s < 3; ++s) t[s + 1] = t[s] + steps[orders[o][s]];
          if (o >= 3) std::swap(t[0], t[1]);  // Odd orders of the axes turn inside out.
          tetrahedra.push_back(t);
        }
      }
    }
  }
  out.tetrahedra.resize(4, static_cast<Eigen::Index>(tetrahedra.size()));
  for (std::size_t t = 0; t < tetrahedra.size(); ++t) out.tetrahedra.col(t) = tetrahedra[t];
  out.tissue.assign(tetrahedra.size(), 1);
  out.fixed_nodes.assign(out.nodes_mm.cols(), 0);
  return out;
}

Eigen::Vector3d PlaceOf(const TetraMesh& mesh, const Location& location) {
  const Corners x = CornersOf(mesh, location.tetrahedron);
  return location.weights[0] * x[0] + location.weights[1] * x[1] + location.weights[2] * x[2] +
         location.weights[3] * x[3];
}

TEST(PointLocation, GivesTheWeightsThatRebuildThePoint) {
  const TetraMesh mesh = Cubes(5);
  ASSERT_EQ(MeasureQuality(mesh).num_inverted, 0);
  const PointLocation location(mesh);
  RandomStream random(1, "points");
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d x(random.Uniform(0, 5), random.Uniform(0, 5), random.Uniform(0, 5));
    const auto found = location.Find(x);
    ASSERT_TRUE(found);
    EXPECT_GE(found->weights.minCoeff(), 0.0);
    EXPECT_NEAR(found->weights.sum(), 1.0, 1e-14);
    EXPECT_LT((PlaceOf(mesh, *found) - x).norm(), 1e-8);
  }
}

TEST(PointLocation, ChoosesTheLowestNumberOnNodesEdgesAndFaces) {
  const TetraMesh mesh = Cubes(3);
  const PointLocation location(mesh);
  const auto lowest = [&](const Eigen::Vector3d& x) {
    for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
      const Corners c = CornersOf(mesh, t);
      Eigen::Matrix3d edges;
      edges << c[1] - c[0], c[2] - c[0], c[3] - c[0];
      const Eigen::Vector3d w = edges.inverse() * (x - c[0]);
      if (w.minCoeff() >= -1e-12 && w.sum() <= 1.0 + 1e-12) return static_cast<int>(t);
    }
    return -1;
  };
  for (int n = 0; n < mesh.nodes_mm.cols(); ++n) {
    const Eigen::Vector3d node = mesh.nodes_mm.col(n);
    for (const Eigen::Vector3d& step :
         {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.5, 0, 0), Eigen::Vector3d(0.5, 0.5, 0),
          Eigen::Vector3d(0.25, 0.5, 0.25)}) {
      const Eigen::Vector3d x = node + step;
      const auto found = location.Find(x);
      EXPECT_EQ(found ? found->tetrahedron : -1, lowest(x)) << x.transpose();
    }
  }
}

TEST(PointLocation, FindsTheSameOnAnyGrid) {
  const TetraMesh mesh = Cubes(4);
  const PointLocation coarse(mesh, 50.0), fine(mesh, 0.1);
  RandomStream random(/*seed=*/3, "places");
  for (int k = 0; k < 500; ++k) {
    Eigen::Vector3d x = 4.4 * Eigen::Vector3d(random.Uniform(), random.Uniform(), random.Uniform());
    if (k % 5 == 0) x = x.array().round();  // On nodes.
    const auto a = coarse.Find(x), b = fine.Find(x);
    ASSERT_EQ(a.has_value(), b.has_value());
    if (a) {
      EXPECT_EQ(a->tetrahedron, b->tetrahedron);
    }
  }
}

TEST(PointLocation, FindsNothingOutsideOrAtNotANumber) {
  const PointLocation location(shapes::TwoTetrahedra());
  EXPECT_FALSE(location.Find({-0.1, 0.2, 0.2}));
  EXPECT_FALSE(location.Find({0.9, 0.9, 0.1}));  // In the box, not in the mesh.
  EXPECT_FALSE(location.Find({std::numeric_limits<double>::quiet_NaN(), 0, 0}));
  EXPECT_FALSE(location.Find({1e300, 0, 0}));
  EXPECT_EQ(location.Find({0.1, 0.1, 0.1})->tetrahedron, 0);
  EXPECT_EQ(location.Find({0.6, 0.6, 0.6})->tetrahedron, 1);
  EXPECT_THROW(PointLocation(TetraMesh{}), InputError);
}

}  // namespace
}  // namespace acus::mesh
