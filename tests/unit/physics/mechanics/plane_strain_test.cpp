#include "acus/physics/mechanics/elements/plane_strain.h"

#include <Eigen/Cholesky>
#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::mechanics {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;
using testing::HasSubstr;
using testing::ThrowsMessage;

std::vector<ElasticTissue> Uniform(const PlaneGrid& grid, double modulus_mpa, double ratio) {
  return std::vector<ElasticTissue>(grid.num_triangles(), {modulus_mpa, ratio});
}

/// u = a + B x at every node.
VectorXd LinearField(const PlaneGrid& grid, const Vector2d& a, const Eigen::Matrix2d& b) {
  VectorXd u(2 * grid.num_nodes());
  for (int n = 0; n < grid.num_nodes(); ++n) u.segment<2>(2 * n) = a + b * grid.PositionMm(n);
  return u;
}

TEST(PlaneGrid, FindsEveryPlaceAndInterpolatesLinearly) {
  const PlaneGrid grid{7, 5, 2.5};
  RandomStream random(1, "points");
  for (int i = 0; i < 2000; ++i) {
    Vector2d p(random.Uniform(0, 15), random.Uniform(0, 10));
    if (i % 3 == 0) p.x() = 2.5 * std::floor(p.x() / 2.5);  // On edges,
    if (i % 5 == 0) p.y() = 2.5 * std::floor(p.y() / 2.5);  // and on nodes.
    const PlaneGrid::Place place = grid.PlaceOf(p);
    ASSERT_GE(place.triangle, 0);
    EXPECT_EQ(place.node, grid.Triangle(place.triangle));
    Vector2d found = Vector2d::Zero();
    for (int k = 0; k < 3; ++k) {
      EXPECT_GE(place.weight[k], -1e-12);
      found += place.weight[k] * grid.PositionMm(place.node[k]);
    }
    EXPECT_LT((found - p).norm(), 1e-12);
  }
  for (const Vector2d& outside : {Vector2d(-0.01, 5), Vector2d(15.01, 5), Vector2d(5, -0.01),
                                  Vector2d(5, 10.01), Vector2d(std::nan(""), 5)}) {
    EXPECT_EQ(grid.PlaceOf(outside).triangle, -1);
  }
}

TEST(PlaneStrain, PassesThePatchTestWithAndWithoutMeanDilatation) {
  const PlaneGrid grid{9, 7, 1.7};
  Eigen::Matrix2d gradient;
  gradient << 0.01, -0.02, 0.035, -0.004;
  for (const double ratio : {0.0, 0.3, 0.49, 0.4999}) {
    for (const Dilatation dilatation : {Dilatation::kTriangle, Dilatation::kCell}) {
      const double modulus_mpa = 0.013;
      const auto k = PlaneStiffness(grid, Uniform(grid, modulus_mpa, ratio), dilatation);
      const VectorXd u = LinearField(grid, Vector2d(0.3, -2.0), gradient);
      const VectorXd force = k * u;
      const double scale = k.diagonal().maxCoeff() * gradient.norm() * grid.spacing_mm;
      for (int row = 1; row + 1 < grid.rows; ++row) {
        for (int column = 1; column + 1 < grid.columns; ++column) {
          EXPECT_LT(force.segment<2>(2 * grid.Node(column, row)).norm(), 1e-10 * scale);
        }
      }
      // Energy per volume: G e:e + lambda / 2 tr(e)^2.
      const double g = modulus_mpa / (2 * (1 + ratio));
      const double lambda = modulus_mpa * ratio / ((1 + ratio) * (1 - 2 * ratio));
      const Eigen::Matrix2d e = 0.5 * (gradient + gradient.transpose());
      const double area_mm2 = 8 * 6 * 1.7 * 1.7;
      const double want = area_mm2 * (g * e.squaredNorm() + 0.5 * lambda * e.trace() * e.trace());
      EXPECT_NEAR(0.5 * u.dot(force), want, 1e-10 * want);
    }
  }
}

TEST(PlaneStrain, RigidMotionCostsNothingAndStiffnessIsSymmetric) {
  const PlaneGrid grid{6, 6, 3.0};
  std::vector<ElasticTissue> tissue = Uniform(grid, 0.02, 0.49);
  for (int t = 0; t < grid.num_triangles(); t += 3) tissue[t] = {20.0, 0.3};
  const Eigen::MatrixXd k = PlaneStiffness(grid, tissue, Dilatation::kCell);
  Eigen::Matrix2d spin;
  spin << 0, -1, 1, 0;
  EXPECT_LT((k * LinearField(grid, Vector2d(1, 2), spin)).norm(), 1e-10 * k.norm());
  EXPECT_LT((k - k.transpose()).norm(), 1e-13 * k.norm());
}

TEST(InvertPlane, IsTheInverseOnTheFreeNodes) {
  const PlaneGrid grid{8, 9, 2.0};
  std::vector<ElasticTissue> tissue = Uniform(grid, 0.02, 0.49);
  for (int t = 0; t < 14; ++t) tissue[t].youngs_modulus_mpa = kEmptyMpa;  // The first row: air.
  for (int t = 60; t < 80; ++t) tissue[t] = {20.0, 0.45};
  std::vector<char> fixed(grid.num_nodes(), 0);
  for (int c = 0; c < grid.columns; ++c) fixed[grid.Node(c, grid.rows - 1)] = 1;
  const PlaneCompliance inverse = InvertPlane(grid, tissue, fixed, Dilatation::kCell);
  EXPECT_EQ(inverse.num_dofs(), 2 * 8 * 7);
  const Eigen::MatrixXd k = PlaneStiffness(grid, tissue, Dilatation::kCell);
  std::vector<int> free;
  for (int n = 0; n < grid.num_nodes(); ++n) {
    const bool moves = n >= 8 && fixed[n] == 0;
    ASSERT_EQ(inverse.dof_of_node[n], moves ? static_cast<int>(free.size()) : -1);
    if (moves) free.insert(free.end(), {2 * n, 2 * n + 1});
  }
  const Eigen::MatrixXd unit = k(free, free) * inverse.matrix;
  EXPECT_LT((unit - Eigen::MatrixXd::Identity(unit.rows(), unit.cols())).norm(), 1e-8);
  EXPECT_EQ(inverse.matrix, inverse.matrix.transpose());
}

TEST(EmptyUnsupported, TakesAwayIslandsAndWhatHangsOnOneCorner) {
  const PlaneGrid grid{6, 6, 1.0};
  std::vector<ElasticTissue> tissue(grid.num_triangles(), {kEmptyMpa, 0.49});
  const auto fill = [&](int column, int row) {
    const int cell = row * 5 + column;
    tissue[2 * cell] = tissue[2 * cell + 1] = {0.02, 0.49};
  };
  for (int c = 0; c < 5; ++c) fill(c, 4);  // On the fixed bottom,
  fill(2, 3);
  fill(3, 2);  // joined by a corner only,
  fill(0, 0);  // and an island.
  std::vector<char> fixed(grid.num_nodes(), 0);
  for (int c = 0; c < 6; ++c) fixed[grid.Node(c, 5)] = 1;
  EXPECT_EQ(EmptyUnsupported(grid, fixed, tissue), 4);
  EXPECT_EQ(EmptyUnsupported(grid, fixed, tissue), 0);
  EXPECT_EQ(tissue[2 * (3 * 5 + 2)].youngs_modulus_mpa, 0.02);
  EXPECT_EQ(InvertPlane(grid, tissue, fixed, Dilatation::kCell).num_dofs(), 2 * 8);
}

TEST(InvertPlane, SaysWhatIsWrong) {
  const PlaneGrid grid{4, 4, 1.0};
  std::vector<ElasticTissue> tissue = Uniform(grid, 0.02, 0.49);
  std::vector<char> fixed(grid.num_nodes(), 1);
  EXPECT_THROW(InvertPlane(grid, tissue, fixed, Dilatation::kCell), InputError);  // All fixed.
  fixed.assign(grid.num_nodes(), 0);
  EXPECT_THROW(InvertPlane(grid, tissue, fixed, Dilatation::kCell), InputError);  // None.
  fixed[0] = 1;
  EXPECT_THAT([&] { InvertPlane(grid, tissue, fixed, Dilatation::kCell); },  // A hinge.
              ThrowsMessage<InputError>(HasSubstr("unknown 30 of 30")));
  fixed[1] = 1;
  EXPECT_NO_THROW(InvertPlane(grid, tissue, fixed, Dilatation::kCell));
  for (const ElasticTissue& bad : {ElasticTissue{-1.0, 0.3}, ElasticTissue{1.0, 0.5},
                                   ElasticTissue{1.0, -1.0}, ElasticTissue{std::nan(""), 0.3}}) {
    tissue[3] = bad;
    EXPECT_THROW(InvertPlane(grid, tissue, fixed, Dilatation::kCell), InputError);
  }
}

}  // namespace
}  // namespace acus::mechanics
