// What linear elements must give exactly: constant strain, layer by layer.
#include <gtest/gtest.h>

#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

Eigen::Matrix3d Gradient() {
  Eigen::Matrix3d g;
  g << 0.03, 0.02, -0.01, 0.01, -0.02, 0.04, -0.02, 0.03, 0.01;
  return g;
}

TEST(MechanicsPatch, ConstantStrainIsExactOnAnIrregularMesh) {
  mesh::TetraMesh box = BoxMesh({6, 5, 4}, {-20, 0, 10}, {40, 50, 50}, 0.18);
  FixSurface(box);
  const Eigen::Matrix3Xd exact = Gradient() * box.nodes_mm;
  for (const ElementKind kind : kBothElements) {
    for (const double poissons_ratio : {0.0, 0.3, 0.49, 0.4999}) {
      const StaticSolver solver(box, UniformTable(0.01, poissons_ratio), kind);
      const Eigen::Matrix3Xd u =
          solver.Displacements(Eigen::Matrix3Xd::Zero(3, exact.cols()), exact);
      EXPECT_LT((u - exact).norm(), 1e-10 * exact.norm()) << poissons_ratio;
    }
  }
}

TEST(MechanicsPatch, EachLayerOfAStretchedBlockHasItsOwnConstantStrain) {
  mesh::TetraMesh box = BoxMesh({4, 4, 6}, {0, 0, 0}, {40, 40, 60}, 0.18);
  // Layers up to 20, 40 and 60 mm; nodes of the interfaces go back onto them.
  for (Eigen::Index i = 0; i < box.nodes_mm.cols(); ++i) {
    double& z = box.nodes_mm(2, i);
    for (const double interface_mm : {20.0, 40.0}) {
      if (std::abs(z - interface_mm) < 2.0) z = interface_mm;
    }
  }
  for (std::size_t t = 0; t < box.tissue.size(); ++t) {
    const mesh::Corners c = mesh::CornersOf(box, static_cast<int>(t));
    const double z = 0.25 * (c[0] + c[1] + c[2] + c[3]).z();
    box.tissue[t] = z < 20.0 ? 3 : z < 40.0 ? 2 : 1;
  }
  FixSurface(box);
  ElasticityTable table = UniformTable(0.01, 0.3);
  table.tissue[1] = {0.1, 0.49};
  table.tissue[2] = {0.003, 0.499};
  // No strain across: the stress M e is the same in all layers, with M = K + 4 G / 3.
  const auto modulus = [&](int tissue) {
    const ElasticTissue& layer = table.tissue[tissue];
    return layer.BulkModulusMpa() + 4.0 / 3.0 * layer.ShearModulusMpa();
  };
  const auto stretch = [&](const Eigen::Vector3d& x) {
    const double z = x.z();
    return Eigen::Vector3d(
        0, 0,
        0.001 * (std::min(z, 20.0) / modulus(3) + std::clamp(z - 20.0, 0.0, 20.0) / modulus(2) +
                 std::max(z - 40.0, 0.0) / modulus(1)));
  };
  const Eigen::Matrix3Xd exact = AtNodes(box, stretch);
  for (const ElementKind kind : kBothElements) {
    const StaticSolver solver(box, table, kind);
    const Eigen::Matrix3Xd u = solver.Displacements(Eigen::Matrix3Xd::Zero(3, exact.cols()), exact);
    EXPECT_LT((u - exact).norm(), 1e-10 * exact.norm());
  }
}

TEST(MechanicsPatch, PulledBlockStretchesAndThinsAsAFreeBar) {
  mesh::TetraMesh box = BoxMesh({5, 4, 6}, {0, 0, 0}, {10, 8, 12}, 0.18);
  const double pull_mpa = 0.001;
  const double e_mpa = 0.02;
  for (const ElementKind kind : kBothElements) {
    for (const double nu : {0.3, 0.499}) {
      // Held at three nodes where the free bar would have them: no force is needed there.
      const auto bar = [&](const Eigen::Vector3d& x) {
        return Eigen::Vector3d(pull_mpa / e_mpa * Eigen::Vector3d(-nu * x.x(), -nu * x.y(), x.z()));
      };
      Fix(box, [](const Eigen::Vector3d& x) {
        return x.z() == 0.0 && (x.head<2>().isZero() || x.head<2>() == Eigen::Vector2d(10, 0) ||
                                x.head<2>() == Eigen::Vector2d(0, 8));
      });
      const Eigen::Matrix3Xd exact = AtNodes(box, bar);
      const auto on_ends = [](const Eigen::Vector3d& x) { return x.z() == 0.0 || x.z() == 12.0; };
      const Eigen::Matrix3Xd load = TractionLoad(box, on_ends, [&](const Eigen::Vector3d& x) {
        return Eigen::Vector3d(0, 0, x.z() > 6.0 ? pull_mpa : -pull_mpa);
      });
      const StaticSolver solver(box, UniformTable(e_mpa, nu), kind);
      EXPECT_LT((solver.Displacements(load, exact) - exact).norm(), 1e-10 * exact.norm()) << nu;
      EXPECT_LT((solver.Forces(exact) - load).norm(), 1e-10 * load.norm()) << nu;
    }
  }
}

TEST(MechanicsPatch, RenumberingLeavesDisplacementsUnchanged) {
  mesh::TetraMesh box = BoxMesh({12, 10, 9}, {0, 0, 0}, {60, 50, 45}, 0.18);
  Fix(box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
  for (std::size_t t = 0; t < box.tissue.size(); ++t) {
    box.tissue[t] = box.nodes_mm(2, box.tetrahedra(0, static_cast<int>(t))) > 25.0 ? 1 : 2;
  }
  ElasticityTable table = UniformTable(0.01, 0.49);
  table.tissue[1] = {0.1, 0.49};
  const auto push = [](const Eigen::Vector3d& x) {
    return x.head<2>().norm() < 20.0 ? Eigen::Vector3d(1e-4, 0, -1e-3) : Eigen::Vector3d(0, 0, 0);
  };
  const auto on_top = [](const Eigen::Vector3d& x) { return x.z() == 45.0; };
  for (const ElementKind kind : kBothElements) {
    const Eigen::Matrix3Xd u =
        StaticSolver(box, table, kind).Displacements(TractionLoad(box, on_top, push));
    double largest = 0.0;
    for (const std::uint64_t seed : {1, 2, 3}) {
      const RenumberedMesh other = Renumbered(box, seed);
      const Eigen::Matrix3Xd v = StaticSolver(other.mesh, table, kind)
                                     .Displacements(TractionLoad(other.mesh, on_top, push));
      for (Eigen::Index i = 0; i < v.cols(); ++i) {
        largest = std::max(largest, (v.col(i) - u.col(other.old_node[i])).norm());
      }
    }
    const double scale_mm = u.colwise().norm().maxCoeff();
    RecordProperty(kind == ElementKind::kLinear ? "linear" : "averaged_dilatation",
                   testing::PrintToString(largest / scale_mm));
    EXPECT_LT(largest, 1e-12 * scale_mm) << largest / scale_mm;
    EXPECT_GT(scale_mm, 0.1);
  }
}

}  // namespace
}  // namespace acus::mechanics
