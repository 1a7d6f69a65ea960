#include "acus/physics/mechanics/elements/stiffness.h"

#include <gmock/gmock.h>

#include "acus/base/core/error.h"
#include "support/box_mesh.h"

namespace acus::mechanics {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using testing_support::BoxMesh;
using testing_support::Fix;

ElasticityTable TableOf(double youngs_modulus_mpa, double poissons_ratio) {
  ElasticityTable table;
  table.file = "test.json";
  table.tissue[4] = {youngs_modulus_mpa, poissons_ratio};
  table.named.set(4);
  return table;
}

Eigen::VectorXd Displaced(const mesh::TetraMesh& mesh, const Eigen::Matrix3d& gradient,
                          const Eigen::Vector3d& shift) {
  const Eigen::Matrix3Xd u = (gradient * mesh.nodes_mm).colwise() + shift;
  return Eigen::Map<const Eigen::VectorXd>(u.data(), u.size());
}

class Stiffness : public testing::TestWithParam<ElementKind> {};

INSTANTIATE_TEST_SUITE_P(Elements, Stiffness,
                         testing::Values(ElementKind::kLinear, ElementKind::kAveragedDilatation));

TEST_P(Stiffness, MotionWithoutStrainNeedsNoForce) {
  const mesh::TetraMesh box = BoxMesh({3, 4, 2}, {-10, 0, 5}, {20, 30, 40}, 0.15);
  const auto k = AssembleStiffness(box, TableOf(0.01, 0.49), GetParam());
  Eigen::Matrix3d turn;
  turn << 0, -3, 2, 3, 0, -1, -2, 1, 0;
  const Eigen::VectorXd force = k.selfadjointView<Eigen::Lower>() * Displaced(box, turn, {1, 2, 3});
  EXPECT_LT(force.lpNorm<Eigen::Infinity>(), 1e-11);
}

TEST_P(Stiffness, EnergyOfAConstantStrainIsThatOfTheSolid) {
  const mesh::TetraMesh box = BoxMesh({3, 4, 2}, {-10, 0, 5}, {20, 30, 40}, 0.15);
  const ElasticityTable table = TableOf(0.01, 0.3);
  const auto k = AssembleStiffness(box, table, GetParam());
  Eigen::Matrix3d gradient;
  gradient << 0.1, 0.02, -0.03, 0.05, -0.04, 0.01, 0.02, 0.06, 0.03;
  const Eigen::VectorXd u = Displaced(box, gradient, {0, 0, 0});
  const Eigen::Matrix3d strain = 0.5 * (gradient + gradient.transpose());
  const double g_mpa = 0.01 / 2.6;
  const double lambda_mpa = 0.01 * 0.3 / (1.3 * 0.4);
  const double density =
      0.5 * lambda_mpa * strain.trace() * strain.trace() + g_mpa * strain.squaredNorm();
  const Eigen::VectorXd force = k.selfadjointView<Eigen::Lower>() * u;
  EXPECT_NEAR(0.5 * u.dot(force) / (density * 30 * 30 * 35), 1.0, 1e-12);
}

TEST_P(Stiffness, TetrahedraThatAreHeldOrExcludedAddNothing) {
  mesh::TetraMesh box = BoxMesh({2, 2, 4}, {0, 0, 0}, {10, 10, 20});
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() <= 10.0; });
  for (std::size_t t = 0; t < box.tissue.size(); ++t) {
    double top_mm = 0.0;
    for (const int node : box.tetrahedra.col(static_cast<int>(t))) {
      top_mm = std::max(top_mm, box.nodes_mm(2, node));
    }
    if (top_mm <= 10.0) box.tissue[t] = 5;
  }
  const auto k = AssembleStiffness(box, TableOf(0.01, 0.3), GetParam());  // Needs no row for bone.
  EXPECT_EQ(k.col(0).nonZeros(), 0);
  EXPECT_EQ(k.rows(), 3 * box.nodes_mm.cols());
  const std::vector<std::uint8_t> all(box.tissue.size(), 1);
  EXPECT_EQ(AssembleStiffness(box, TableOf(0.01, 0.3), GetParam(), all).nonZeros(), 0);
}

TEST_P(Stiffness, OfFreeNodesIsThatWithoutTheRowsOfTheOthers) {
  mesh::TetraMesh box = BoxMesh({2, 3, 2}, {0, 0, 0}, {10, 10, 20}, 0.1);
  Fix(box, [](const Eigen::Vector3d& x) { return x.y() == 0.0; });
  const auto k = AssembleStiffness(box, TableOf(0.01, 0.4), GetParam());
  const FreeNodes free = FindFreeNodes(box);
  const Eigen::MatrixXd dense = FreeStiffness(k, free);
  const Eigen::MatrixXd all = k;
  ASSERT_EQ(dense.rows(), free.num_dofs());
  for (int i = 0; i < dense.rows(); ++i) {
    for (int j = 0; j <= i; ++j) {
      EXPECT_EQ(dense(i, j),
                all(3 * free.mesh_node[i / 3] + i % 3, 3 * free.mesh_node[j / 3] + j % 3));
    }
  }
  EXPECT_TRUE(dense.selfadjointView<Eigen::Lower>().ldlt().isPositive());
}

TEST_P(Stiffness, RefusesWhatCannotBeDeformed) {
  mesh::TetraMesh box = BoxMesh({2, 2, 2}, {0, 0, 0}, {10, 10, 10});
  mesh::TetraMesh inverted = box;
  std::swap(inverted.tetrahedra(0, 7), inverted.tetrahedra(1, 7));
  EXPECT_THAT(
      [&] { AssembleStiffness(inverted, TableOf(0.01, 0.4), GetParam()); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("tetrahedron 7"), HasSubstr("(8.75, 1.25, 2.5) mm"),
                                      HasSubstr("inside out"))));
  mesh::TetraMesh broken = box;
  broken.nodes_mm(1, 13) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(AssembleStiffness(broken, TableOf(0.01, 0.4), GetParam()), InputError);
  box.tissue[3] = 8;
  EXPECT_THAT([&] { AssembleStiffness(box, TableOf(0.01, 0.4), GetParam()); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("'liver'"), HasSubstr("test.json"))));
}

}  // namespace
}  // namespace acus::mechanics
