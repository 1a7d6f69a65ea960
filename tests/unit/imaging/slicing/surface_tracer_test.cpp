#include "acus/imaging/slicing/tracing/surface_tracer.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>

#include "acus/base/core/error.h"
#include "acus/patient/segmentation/voxels/rasterise.h"
#include "support/icosphere.h"

namespace acus::tracing {
namespace {

using mesh::Surface;
using testing_support::Icosphere;

LabelledSurface Labelled(const Surface& surface, int label) {
  return {surface, mesh::CheckClosed(surface, "surface"), static_cast<volume::Label>(label)};
}

std::vector<LabelChange> Traced(const SurfaceTracer& tracer, const std::vector<PathPlace>& path) {
  SurfaceTracer::Buffers buffers(tracer);
  std::vector<LabelChange> out;
  tracer.Trace(path, buffers, out);
  return out;
}

/// A straight path whose places are numbered by mm.
std::vector<PathPlace> Straight(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  return {{from, 0.0}, {to, (to - from).norm()}};
}

std::vector<int> LabelsOf(const std::vector<LabelChange>& changes) {
  std::vector<int> out;
  for (const LabelChange& c : changes) out.push_back(c.label);
  return out;
}

volume::Label LabelAt(const SurfaceTracer& tracer, const Eigen::Vector3d& place) {
  return Traced(tracer, {{place, 0.0}}).back().label;
}

Surface Turned(Surface surface) {
  surface.triangles.row(1).swap(surface.triangles.row(2));
  return surface;
}

TEST(SurfaceTracer, MeetsABallWhereTheChordDoes) {
  // Faces lie up to 0.008 mm within the sphere.
  const SurfaceTracer tracer({Labelled(Icosphere(20.0, 5, {5, -3, 8}), 8)}, 1);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> off(-18.0, 18.0);
  for (int n = 0; n < 500; ++n) {
    const double x = off(random), y = off(random) * 0.3;
    const Eigen::Vector3d middle(5, -3, 8);
    const Eigen::Vector3d from = middle + Eigen::Vector3d(x, y, -30.0);
    const auto changes = Traced(tracer, Straight(from, from + Eigen::Vector3d(0, 0, 60)));
    ASSERT_EQ(LabelsOf(changes), (std::vector<int>{0, 8, 0}));
    const double rise = std::sqrt(400.0 - x * x - y * y);
    const double slant_mm = 0.008 * 20.0 / rise;
    EXPECT_NEAR(changes[1].at, 30.0 - rise, 1.1 * slant_mm);
    EXPECT_NEAR(changes[2].at, 30.0 + rise, 1.1 * slant_mm);
  }
}

TEST(SurfaceTracer, BeginsAndEndsInside) {
  const SurfaceTracer tracer({Labelled(Icosphere(20.0, 3), 8)}, 1);
  EXPECT_EQ(LabelsOf(Traced(tracer, Straight({1, 2, 3}, {40, 0, 0}))), (std::vector<int>{8, 0}));
  EXPECT_EQ(LabelsOf(Traced(tracer, Straight({40, 0, 0}, {1, 2, 3}))), (std::vector<int>{0, 8}));
  EXPECT_EQ(LabelsOf(Traced(tracer, Straight({1, 0, 0}, {1, 2, 3}))), (std::vector<int>{8}));
  EXPECT_EQ(LabelsOf(Traced(tracer, Straight({50, 0, 0}, {1e9, 2, 3}))), (std::vector<int>{0}));
  EXPECT_EQ(LabelsOf(Traced(tracer, Straight({-1e4, 1, 0}, {1e4, 1, 0}))),
            (std::vector<int>{0, 8, 0}));
  EXPECT_EQ(LabelAt(tracer, {0.1, 0, 0}), 8);
  EXPECT_EQ(LabelAt(tracer, {20.1, 0, 0}), 0);
}

TEST(SurfaceTracer, TheLastSurfaceCountsWhereTheyOverlap) {
  const SurfaceTracer tracer({Labelled(Icosphere(30.0, 4), 4), Labelled(Icosphere(10.0, 4), 8),
                              Labelled(Icosphere(8.0, 4, {9, 0, 0}), 9)},
                             1);
  const auto changes = Traced(tracer, Straight({-40, 0.1, 0.2}, {40, 0.1, 0.2}));
  EXPECT_EQ(LabelsOf(changes), (std::vector<int>{0, 4, 8, 9, 4, 0}));
  const double at[] = {0, 10, 30, 41, 57, 70};
  for (std::size_t n = 0; n < 6; ++n) EXPECT_NEAR(changes[n].at, at[n], 0.05) << n;
  // The other way round the small ball hides nothing: only what is last counts.
  const SurfaceTracer hidden({Labelled(Icosphere(10.0, 4), 8), Labelled(Icosphere(30.0, 4), 4)}, 1);
  EXPECT_EQ(LabelsOf(Traced(hidden, Straight({-40, 0, 0}, {40, 0, 0}))),
            (std::vector<int>{0, 4, 0}));
}

TEST(SurfaceTracer, ManySurfacesAreToldApart) {
  // More than one word of bits.
  std::vector<LabelledSurface> nested;
  for (int n = 0; n < 130; ++n) nested.push_back(Labelled(Icosphere(131.0 - n, 2), 1 + n));
  const SurfaceTracer tracer(std::move(nested), 1);
  const auto changes = Traced(tracer, Straight({-140, 0.3, 0.1}, {0, 0.3, 0.1}));
  ASSERT_EQ(changes.size(), 131U);
  for (std::size_t n = 0; n < changes.size(); ++n) EXPECT_EQ(changes[n].label, n);
}

TEST(SurfaceTracer, PathsThroughEveryNodeAndEdgeCrossOnce) {
  const Surface ball = Icosphere(20.0, 3);
  const SurfaceTracer tracer({Labelled(ball, 8)}, 1);
  const auto through = [&](const Eigen::Vector3d& place) {
    const Eigen::Vector3d far = 3.0 * place;
    // Nodes are multiples of the unit, and so is a path that ends at three times their place.
    EXPECT_EQ(LabelsOf(Traced(tracer, Straight(far, {0, 0, 0}))), (std::vector<int>{0, 8}));
    EXPECT_EQ(LabelsOf(Traced(tracer, Straight(far, -far))), (std::vector<int>{0, 8, 0}));
    // Along the normal of the plane too, and bent in the place itself.
    for (const Eigen::Vector3d& off : {Eigen::Vector3d(30, 0, 0), Eigen::Vector3d(0, 30, 0)}) {
      const auto bent = Traced(tracer, {{place + off, 0}, {place, 1}, {{0, 0, 0}, 2}});
      EXPECT_EQ(bent.back().label, 8);
      EXPECT_EQ(Traced(tracer, {{{0, 0, 0}, 0}, {place, 1}, {place + 3.0 * off, 2}}).back().label,
                0);
    }
  };
  const double unit = tracer.unit_mm();
  const auto rounded = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    return (p / unit).array().round() * unit;
  };
  for (Eigen::Index n = 0; n < ball.nodes_mm.cols(); ++n) through(rounded(ball.nodes_mm.col(n)));
  for (Eigen::Index t = 0; t < ball.triangles.cols(); ++t) {
    through(0.5 * (rounded(ball.nodes_mm.col(ball.triangles(0, t))) +
                   rounded(ball.nodes_mm.col(ball.triangles(1, t)))));
  }
}

TEST(SurfaceTracer, TrianglesMayFaceEitherWayAndOverlapsAreNoHoles) {
  const Surface ball = Icosphere(8.0, 3);
  const std::vector<PathPlace> path = Straight({-20, 0.4, 0.3}, {20, 0.4, 0.3});
  const auto outwards = Traced(SurfaceTracer({Labelled(ball, 5)}, 1), path);
  const auto inwards = Traced(SurfaceTracer({Labelled(Turned(ball), 5)}, 1), path);
  ASSERT_EQ(LabelsOf(outwards), (std::vector<int>{0, 5, 0}));
  EXPECT_EQ(LabelsOf(inwards), LabelsOf(outwards));
  EXPECT_DOUBLE_EQ(inwards[1].at, outwards[1].at);
  Surface mixed = ball;
  std::swap(mixed.triangles(1, 17), mixed.triangles(2, 17));
  const LabelledSurface unoriented = Labelled(mixed, 5);
  EXPECT_EQ(unoriented.winding, mesh::Winding::kUnoriented);
  const SurfaceTracer tracer({unoriented}, 1);
  const SurfaceTracer same({Labelled(ball, 5)}, 1);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-9.0, 9.0);
  for (int n = 0; n < 1000; ++n) {
    const Eigen::Vector3d at(place(random), place(random), place(random));
    EXPECT_EQ(LabelAt(tracer, at), LabelAt(same, at));
  }
  // Two balls in one surface, overlapping: the middle is inside both.
  const Surface two =
      testing_support::Joined(Icosphere(6.0, 3, {-2, 0, 0}), Icosphere(6.0, 3, {2, 0, 0}));
  EXPECT_EQ(LabelsOf(Traced(SurfaceTracer({Labelled(two, 5)}, 1), path)),
            (std::vector<int>{0, 5, 0}));
}

TEST(SurfaceTracer, AgreesWithTheFillingOfVoxels) {
  volume::Geometry g;
  g.size = {80, 70, 60};
  g.spacing_mm.setConstant(0.5);
  g.origin_mm = {-20.3, -17.1, -15.2};
  volume::LabelMap labels(g);
  std::vector<LabelledSurface> surfaces;
  for (const auto& [radius_mm, label] : {std::pair{16.0, 4}, {9.0, 8}, {7.0, 9}}) {
    surfaces.push_back(
        Labelled(Icosphere(radius_mm, 4, {label - 4.0, 0.5 * label - 2.0, 0}), label));
    segmentation::PaintInside(surfaces.back().surface, surfaces.back().winding,
                              surfaces.back().label, 1, labels);
  }
  const SurfaceTracer tracer(std::move(surfaces), 1);
  SurfaceTracer::Buffers buffers(tracer);
  std::vector<LabelChange> changes;
  std::size_t different = 0;
  for (int k = 0; k < g.size[2]; ++k) {
    for (int j = 0; j < g.size[1]; ++j) {
      const Eigen::Vector3d from = g.ct_from_index() * Eigen::Vector3d(0, j, k);
      const Eigen::Vector3d to = g.ct_from_index() * Eigen::Vector3d(g.size[0] - 1, j, k);
      const std::vector<PathPlace> path = {{from, 0.0}, {to, g.size[0] - 1.0}};
      tracer.Trace(path, buffers, changes);
      std::size_t n = 0;
      for (int i = 0; i < g.size[0]; ++i) {
        while (n + 1 < changes.size() && changes[n + 1].at <= i) ++n;
        if (changes[n].label == labels.At(i, j, k)) continue;
        // Only where rounding to the unit matters.
        ++different;
        const double before = std::abs(changes[n].at - i);
        const double after = n + 1 < changes.size() ? std::abs(changes[n + 1].at - i) : 1e9;
        EXPECT_LT(std::min(before, after), 1e-3);
      }
    }
  }
  EXPECT_LE(different, 3U);
}

TEST(SurfaceTracer, ABentPathIsTheSumOfItsPieces) {
  const SurfaceTracer tracer({Labelled(Icosphere(20.0, 5), 8)}, 1);
  // Over a hump: in at x = -17.3, y = 10; out at the top; and in again.
  const auto changes = Traced(tracer, {{{-40, 10, 0}, 0.0},
                                       {{0, 10, 0}, 10.0},
                                       {{0, 30, 0}, 20.0},
                                       {{0, 10, 0}, 30.0},
                                       {{0, 10, 0}, 35.0},
                                       {{0, 0, 0}, 40.0}});
  EXPECT_EQ(LabelsOf(changes), (std::vector<int>{0, 8, 0, 8}));
  EXPECT_NEAR(changes[1].at, (40.0 - std::sqrt(300.0)) / 4.0, 0.01);
  EXPECT_NEAR(changes[2].at, 15.0, 0.01);
  EXPECT_NEAR(changes[3].at, 25.0, 0.01);
}

TEST(SurfaceTracer, TheHierarchyDoesNotDependOnThreads) {
  const auto surfaces = [] {
    return std::vector<LabelledSurface>{Labelled(Icosphere(20.0, 5), 8),
                                        Labelled(Icosphere(7.0, 4, {3, 4, 5}), 9)};
  };
  const SurfaceTracer one(surfaces(), 1), three(surfaces(), 3);
  std::mt19937 random(8);
  std::uniform_real_distribution<double> place(-22.0, 22.0);
  for (int n = 0; n < 2000; ++n) {
    const auto path = Straight({place(random), place(random), place(random)},
                               {place(random), place(random), place(random)});
    const auto a = Traced(one, path), b = Traced(three, path);
    ASSERT_EQ(LabelsOf(a), LabelsOf(b));
    for (std::size_t c = 0; c < a.size(); ++c) ASSERT_EQ(a[c].at, b[c].at);
  }
}

TEST(SurfaceTracer, FlatTrianglesAndMistakesAreHandled) {
  // A node doubled along an edge gives triangles without area, which change nothing.
  Surface ball = Icosphere(20.0, 2);
  ball.triangles.conservativeResize(3, ball.triangles.cols() + 2);
  ball.triangles.rightCols(2) << 0, 11, 11, 0, 11, 0;
  EXPECT_EQ(
      LabelsOf(Traced(SurfaceTracer({Labelled(ball, 8)}, 1), Straight({-30, 0, 0}, {30, 0, 0}))),
      (std::vector<int>{0, 8, 0}));
  EXPECT_THROW(SurfaceTracer({}, 1), InputError);
  EXPECT_THROW(SurfaceTracer({LabelledSurface{}}, 1), InputError);
  Surface wrong = Icosphere(20.0, 1);
  wrong.triangles(0, 0) = 9999;
  EXPECT_THROW(SurfaceTracer({{wrong, mesh::Winding::kOriented, 8}}, 1), InputError);
  wrong = Icosphere(20.0, 1);
  wrong.nodes_mm(1, 3) = std::nan("");
  EXPECT_THROW(SurfaceTracer({{wrong, mesh::Winding::kOriented, 8}}, 1), InputError);
}

}  // namespace
}  // namespace acus::tracing
