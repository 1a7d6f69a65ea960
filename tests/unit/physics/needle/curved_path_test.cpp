#include "acus/physics/needle/curved_path.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace acus::needle {
namespace {

using Eigen::Vector3d;

PathNode Tissue(double stiffness_n_per_mm2, std::uint8_t label = 1) {
  PathNode tissue;
  tissue.stiffness_n_per_mm2 = stiffness_n_per_mm2;
  tissue.tissue = label;
  return tissue;
}

CurvedPath Begun(double spacing_mm) {
  CurvedPath path;
  path.spacing_mm = spacing_mm;
  path.Begin(Tissue(0.1));
  return path;
}

double LastPieceMm(const CurvedPath& path) {
  if (path.num_nodes < 2) return 0.0;
  return path.tip().depth_mm - path.node[path.num_nodes - 2].depth_mm;
}

double LengthOfPieces(const CurvedPath& path) {
  double sum_mm = 0.0;
  for (int i = 1; i < path.num_nodes; ++i) {
    const double piece = (path.node[i].position_mm - path.node[i - 1].position_mm).norm();
    EXPECT_NEAR(piece, path.node[i].depth_mm - path.node[i - 1].depth_mm, 1e-9);
    sum_mm += piece;
  }
  return sum_mm;
}

TEST(CurvedPath, PutsNodesAtTheSpacingAndTakesThemOut) {
  CurvedPath path = Begun(2.0);
  EXPECT_EQ(path.num_nodes, 1);
  for (int i = 0; i < 300; ++i) path.Advance({0.0, 0.0, 2.0}, 0.1, Tissue(0.3));
  EXPECT_NEAR(path.LengthMm(), 30.0, 1e-9);
  EXPECT_NEAR(path.tip().position_mm.z(), 30.0, 1e-9);
  for (int i = 1; i + 1 < path.num_nodes; ++i) EXPECT_NEAR(path.node[i].depth_mm, 2.0 * i, 1e-9);
  const double last = LastPieceMm(path);
  EXPECT_GE(last, 0.5 * 2.0);
  EXPECT_LE(last, 1.5 * 2.0);
  for (int i = 0; i < 149; ++i) {
    path.Retract(0.2);
    EXPECT_NEAR(path.LengthMm(), 30.0 - 0.2 * (i + 1), 1e-9);
    const double piece = LastPieceMm(path);
    EXPECT_TRUE(path.num_nodes == 2 || piece >= 0.999 * 1.0) << piece;
  }
  EXPECT_EQ(path.num_nodes, 2);
  path.Retract(0.3);
  EXPECT_TRUE(path.empty());
}

TEST(CurvedPath, OneLongStepIsAsManyShortOnes) {
  CurvedPath one = Begun(1.0);
  CurvedPath many = Begun(1.0);
  one.Advance({0.6, 0.0, 0.8}, 50.0, Tissue(0.2));
  for (int i = 0; i < 500; ++i) many.Advance({0.6, 0.0, 0.8}, 0.1, Tissue(0.2));
  ASSERT_EQ(one.num_nodes, many.num_nodes);
  for (int i = 0; i < one.num_nodes; ++i) {
    EXPECT_NEAR((one.node[i].position_mm - many.node[i].position_mm).norm(), 0.0, 1e-9);
    EXPECT_NEAR(one.node[i].support_n_per_mm, many.node[i].support_n_per_mm, 1e-9);
  }
  one.Retract(49.0);
  for (int i = 0; i < 490; ++i) many.Retract(0.1);
  EXPECT_NEAR((one.tip().position_mm - many.tip().position_mm).norm(), 0.0, 1e-9);
}

TEST(CurvedPath, SumsTheStiffnessOfWhatItGoesThrough) {
  CurvedPath path = Begun(2.0);
  for (int i = 0; i < 130; ++i) path.Advance(Vector3d::UnitZ(), 0.1, Tissue(0.1, 1));
  for (int i = 0; i < 70; ++i) path.Advance(Vector3d::UnitZ(), 0.1, Tissue(0.5, 2));
  EXPECT_NEAR(path.SupportNPerMm(20.0), 13.0 * 0.1 + 7.0 * 0.5, 1e-9);
  EXPECT_NEAR(path.SupportNPerMm(10.0), 1.0, 1e-9);
  EXPECT_NEAR(path.SupportNPerMm(19.0) - path.SupportNPerMm(17.5), 0.75, 1e-9);
  EXPECT_EQ(path.SupportNPerMm(-1.0), 0.0);
  EXPECT_NEAR(path.SupportNPerMm(99.0), path.SupportNPerMm(20.0), 1e-12);
  EXPECT_EQ(path.tip().tissue, 2);
}

TEST(CurvedPath, InterpolatesAndExtrapolatesByItsPieces) {
  CurvedPath path = Begun(1.0);
  EXPECT_EQ(path.PositionMm(3.0), Vector3d::Zero());
  EXPECT_EQ(path.Direction(0.0, Vector3d::UnitX()), Vector3d::UnitX());
  path.Advance(Vector3d::UnitZ(), 10.0, Tissue(0.1));
  path.Advance(Vector3d::UnitX(), 10.0, Tissue(0.1));
  EXPECT_NEAR((path.PositionMm(5.25) - Vector3d(0, 0, 5.25)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((path.PositionMm(-2.0) - Vector3d(0, 0, -2)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((path.Direction(18.0) - Vector3d::UnitX()).norm(), 0.0, 1e-3);
  const Vector3d beyond = path.PositionMm(path.LengthMm() + 3.0);
  EXPECT_NEAR((beyond - path.tip().position_mm - Vector3d(3, 0, 0)).norm(), 0.0, 1e-3);
  LengthOfPieces(path);
}

TEST(CurvedPath, KeepsItsShapeWhenItIsFull) {
  CurvedPath path = Begun(0.1);
  for (int i = 0; i < 2000; ++i) path.Advance(Vector3d::UnitZ(), 0.05, Tissue(0.1));
  EXPECT_EQ(path.num_nodes, CurvedPath::kMaxNodes);
  EXPECT_NEAR(path.LengthMm(), 100.0, 1e-6);
  EXPECT_NEAR(LengthOfPieces(path), 100.0, 1e-6);
  path.Retract(60.0);
  EXPECT_NEAR(path.tip().position_mm.z(), 40.0, 1e-6);
}

TEST(CurvedPath, IgnoresStepsThatAreNone) {
  CurvedPath path = Begun(1.0);
  path.Advance(Vector3d::UnitZ(), 5.0, Tissue(0.1));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  path.Advance(Vector3d::UnitZ(), nan, Tissue(0.1));
  path.Advance(Vector3d::UnitZ(), -1.0, Tissue(0.1));
  path.Advance(Vector3d::Zero(), 1.0, Tissue(0.1));
  path.Advance({nan, 0.0, 0.0}, 1.0, Tissue(0.1));
  path.Retract(nan);
  path.Retract(-1.0);
  EXPECT_NEAR(path.LengthMm(), 5.0, 1e-12);
  CurvedPath none;
  none.Advance(Vector3d::UnitZ(), 1.0, Tissue(0.1));
  none.Retract(1.0);
  EXPECT_TRUE(none.empty());
}

// Whatever the step, a bevel's path is a circle of its curvature.
TEST(BevelTip, CutsACircleInThePlaneOfItsBevel) {
  for (const double step_mm : {0.02, 0.1, 1.0, 5.0}) {
    BevelTip bevel;
    bevel.curvature_per_mm = 0.0045;
    bevel.roll_rad = std::acos(0.0);  // Towards the tip's +y.
    CurvedPath path = Begun(1.0);
    Vector3d heading = Vector3d::UnitZ();
    for (double done = 0.0; done < 100.0 - 1e-9; done += step_mm) {
      const auto next = bevel.After(step_mm, heading, Vector3d::UnitX(), Vector3d::UnitY());
      path.Advance(next.chord, step_mm, Tissue(0.1));
      heading = next.end;
    }
    const double turn = 0.45;
    const Vector3d end(0.0, (1.0 - std::cos(turn)) / 0.0045, std::sin(turn) / 0.0045);
    // Chords are walked in the length of their arcs: (kappa step)^2 / 24.
    EXPECT_NEAR((path.tip().position_mm - end).norm(), 0.0, 1e-6 + 2e-4 * step_mm * step_mm);
    EXPECT_NEAR(heading.dot(Vector3d(0, std::sin(turn), std::cos(turn))), 1.0, 1e-12);
  }
}

TEST(BevelTip, GoesStraightWithoutCurvatureOrSide) {
  const BevelTip straight;
  const Vector3d t(0.0, 0.6, 0.8);
  EXPECT_EQ(straight.After(3.0, t, Vector3d::UnitX(), Vector3d::UnitY()).chord, t);
  BevelTip bevel;
  bevel.curvature_per_mm = 0.01;
  EXPECT_EQ(bevel.After(3.0, t, t, t).end, t);
}

}  // namespace
}  // namespace acus::needle
