#include "acus/physics/tissue/tip_kernel.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

#include "acus/physics/tissue/local_compliance.h"
#include "support/elastic_box.h"

namespace acus::tissue {
namespace {

using Eigen::Vector3d;

struct KernelBox {
  mesh::TetraMesh mesh;
  mechanics::Compliance compliance;
};

KernelBox MakeKernelBox(int cells, double reach_mm) {
  mesh::TetraMesh mesh =
      testing_support::BoxMesh({cells, cells, cells}, {-24, -24, 0}, {24, 24, 48}, 0.15);
  testing_support::Fix(mesh, [](const Vector3d& x) { return x.z() < 1e-6; });
  const auto reach = [&](const Vector3d& x) { return (x - Vector3d(0, 0, 30)).norm() < reach_mm; };
  return {mesh, testing_support::CondensedOf(
                    mesh, testing_support::ElasticLabels({{4, {0.02, 0.45}}}), reach)};
}

Vector3d Middle(const TipKernel& kernel, const KernelPlace& at) {
  Vector3d sum = Vector3d::Zero();
  for (int r = 0; r < at.place.num_rows; ++r) {
    sum += at.place.weight[static_cast<std::size_t>(r)] *
           kernel.RestOf(at.place.row[static_cast<std::size_t>(r)]);
  }
  return sum;
}

double Total(const KernelPlace& at) {
  double sum = 0.0;
  for (int r = 0; r < at.place.num_rows; ++r) sum += at.place.weight[static_cast<std::size_t>(r)];
  return sum;
}

TEST(TipKernel, IsAMeanAroundItsPlace) {
  const KernelBox box = MakeKernelBox(14, 16.0);
  const TipKernel kernel(box.mesh, box.compliance);
  const Vector3d at(0.7, -0.4, 30.3);
  for (const double radius_mm : {7.4, 12.0}) {
    const KernelPlace ball = kernel.Ball(at, radius_mm);
    EXPECT_NEAR(Total(ball), 1.0, 1e-12);
    EXPECT_LT((Middle(kernel, ball) - at).norm(), 0.08 * radius_mm) << radius_mm;
    EXPECT_LE(ball.self_per_mm, 0.0);
  }
  EXPECT_EQ(kernel.Ball({200, 0, 0}, 7.4).place.num_rows, 0);
}

TEST(TipKernel, FewNodesOfAFineMeshMoveAsAllOfThem) {
  const KernelBox box = MakeKernelBox(24, 9.5);  // Nodes 2 mm apart: some 200 within 7.4 mm.
  const TipKernel kernel(box.mesh, box.compliance);
  const ContactSystem system(box.compliance, {.points = 1, .slots = 0});
  const mechanics::ElasticTissue tissue{0.02, 0.45};
  const Vector3d at(0.3, 0.2, 30.1);
  // All of them, as a plain sum over the nodes of the compliance: they are evenly spread.
  double sum = 0.0, moved = 0.0;
  std::vector<double> weight(static_cast<std::size_t>(box.compliance.num_nodes()));
  for (int row = 0; row < box.compliance.num_nodes(); ++row) {
    const double inside =
        std::max(0.0, 1.0 - (kernel.RestOf(row) - at).squaredNorm() / (7.4 * 7.4));
    sum += weight[static_cast<std::size_t>(row)] = inside * inside;
  }
  for (int i = 0; i < box.compliance.num_nodes(); ++i) {
    const double* column = box.compliance.Values<double>(3 * i + 2);
    for (int j = 0; j < box.compliance.num_nodes(); ++j) {
      moved += weight[static_cast<std::size_t>(i)] * weight[static_cast<std::size_t>(j)] *
               column[3 * j + 2] / (sum * sum);
    }
  }
  const KernelPlace ball = kernel.Ball(at, 7.4);
  EXPECT_LE(ball.place.num_rows, 110);
  const double few = system.Between(ball.place, ball.place)(2, 2) +
                     SphereMobilityMm2PerN(tissue) * ball.self_per_mm;
  EXPECT_NEAR(few / moved, 1.0, 0.03);
}

TEST(TipKernel, DoesNotDependOnNumbers) {
  const KernelBox box = MakeKernelBox(10, 16.0);
  const auto renumbered = testing_support::Renumbered(box.mesh, 5);
  const auto compliance = testing_support::CondensedOf(
      renumbered.mesh, testing_support::ElasticLabels({{4, {0.02, 0.45}}}),
      [&](const Vector3d& x) { return (x - Vector3d(0, 0, 30)).norm() < 16.0; });
  const TipKernel one(box.mesh, box.compliance), other(renumbered.mesh, compliance);
  const Vector3d at(1.1, 0.3, 29.0);
  const KernelPlace a = one.Ball(at, 9.0), b = other.Ball(at, 9.0);
  EXPECT_EQ(a.place.num_rows, b.place.num_rows);
  EXPECT_LT((Middle(one, a) - Middle(other, b)).norm(), 1e-12);
  EXPECT_NEAR(a.self_per_mm, b.self_per_mm, 1e-12);
}

TEST(TipKernel, ADiscLiesOnTheSurface) {
  mesh::TetraMesh mesh = testing_support::BoxMesh({12, 12, 6}, {-24, -24, 0}, {24, 24, 24}, 0.1);
  testing_support::Fix(mesh, [](const Vector3d& x) { return x.z() < 1e-6; });
  const auto compliance = testing_support::ComplianceOf(
      mesh, testing_support::ElasticLabels({{4, {0.02, 0.45}}}), mechanics::Storage::kDouble,
      [](const Vector3d& x) { return (x - Vector3d(0, 0, 24)).norm() < 18.0; });
  const TipKernel kernel(mesh, compliance);
  const KernelPlace disc = kernel.Disc({0.5, 0.3, 24.0}, 12.0);
  EXPECT_NEAR(Total(disc), 1.0, 1e-12);
  EXPECT_GT(disc.place.num_rows, 20);
  EXPECT_EQ(disc.self_per_mm, 0.0);
  EXPECT_LT((Middle(kernel, disc) - Vector3d(0.5, 0.3, 24.0)).norm(), 0.3);
}

}  // namespace
}  // namespace acus::tissue
