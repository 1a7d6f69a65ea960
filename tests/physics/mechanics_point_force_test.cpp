// Forces spread over a small region, against the closed solutions of Boussinesq and Kelvin. The box
// stands for an infinite body: its outer nodes are moved to where they would be in that.
#include <gtest/gtest.h>

#include "acus/data/mesh/point_location.h"
#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"
#include "support/half_space.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

constexpr double kHalfMm = 6.0;  ///< The loaded square or cube reaches so far from its middle.

/// Draws nodes towards the origin, which is in the middle or on a face; elements there get 0.55 of
/// their size. The outer surface stays.
void Grade(mesh::TetraMesh& mesh) {
  const double far_mm = mesh.nodes_mm.cwiseAbs().maxCoeff();
  mesh.nodes_mm =
      mesh.nodes_mm.unaryExpr([&](double x) { return x * (0.55 + 0.45 * std::abs(x) / far_mm); });
}

struct MechanicsPointForceErrors {
  double root_mean_square = 0.0;  ///< From 2.5 half widths of the load on, of the same mean of u.
  double largest = 0.0;           ///< From 4 half widths on, of the displacement at the node.
};

MechanicsPointForceErrors AwayFromTheLoad(const mesh::TetraMesh& mesh, const Eigen::Matrix3Xd& u,
                                          const Eigen::Matrix3Xd& exact) {
  MechanicsPointForceErrors errors;
  double size = 0.0;
  for (Eigen::Index i = 0; i < u.cols(); ++i) {
    const double distance_mm = mesh.nodes_mm.col(i).norm();
    if (distance_mm < 2.5 * kHalfMm || mesh.fixed_nodes[static_cast<std::size_t>(i)]) continue;
    const double error = (u.col(i) - exact.col(i)).squaredNorm();
    errors.root_mean_square += error;
    size += exact.col(i).squaredNorm();
    if (distance_mm < 4.0 * kHalfMm) continue;
    errors.largest = std::max(errors.largest, std::sqrt(error) / exact.col(i).norm());
  }
  errors.root_mean_square = std::sqrt(errors.root_mean_square / size);
  return errors;
}

void ExpectWithin3Percent(const MechanicsPointForceErrors& errors, ElementKind kind,
                          double poissons_ratio) {
  EXPECT_LT(errors.root_mean_square, 0.03) << static_cast<int>(kind) << " " << poissons_ratio;
  EXPECT_LT(errors.largest, 0.03) << static_cast<int>(kind) << " " << poissons_ratio;
}

TEST(MechanicsPointForce, OnAHalfSpaceIsBoussinesqs) {
  mesh::TetraMesh box = BoxMesh({24, 24, 12}, {-48, -48, -48}, {48, 48, 0}, 0.12);
  Grade(box);
  Fix(box, [](const Eigen::Vector3d& x) {
    return x.z() == -48.0 || std::abs(x.x()) == 48.0 || std::abs(x.y()) == 48.0;
  });
  std::vector<SmallForce> forces;
  constexpr int kParts = 12;
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; j < kParts; ++j) {
      forces.push_back({{kHalfMm * ((2 * i + 1.0) / kParts - 1.0),
                         kHalfMm * ((2 * j + 1.0) / kParts - 1.0), 0.0},
                        {0.0, 0.0, -0.01 / (kParts * kParts)}});
    }
  }
  const double pressure_mpa = 0.01 / (4.0 * kHalfMm * kHalfMm);
  const Eigen::Matrix3Xd load = TractionLoad(
      box, [](const Eigen::Vector3d& x) { return x.z() == 0.0; },
      [&](const Eigen::Vector3d& x) {
        const bool is_on = x.head<2>().cwiseAbs().maxCoeff() < kHalfMm;
        return Eigen::Vector3d(0, 0, is_on ? -pressure_mpa : 0.0);
      },
      16);
  EXPECT_NEAR(load.row(2).sum(), -0.01, 1e-4);
  for (const ElementKind kind : kBothElements) {
    for (const double nu : {0.3, 0.499}) {
      if (kind == ElementKind::kLinear && nu > 0.45) continue;  // Locks.
      const ElasticTissue tissue{0.01, nu};
      const Eigen::Matrix3Xd exact = AtNodes(box, [&](const Eigen::Vector3d& x) {
        // Below the load itself, where the sum is not yet the integral, nothing is compared.
        return x.norm() < 2.0 * kHalfMm ? Eigen::Vector3d(0, 0, 0)
                                        : BoussinesqMm(forces, x, tissue);
      });
      const StaticSolver solver(box, UniformTable(0.01, nu), kind);
      const Eigen::Matrix3Xd u = solver.Displacements(load, exact);
      ExpectWithin3Percent(AwayFromTheLoad(box, u, exact), kind, nu);
    }
  }
}

TEST(MechanicsPointForce, InsideAnInfiniteBodyIsKelvins) {
  mesh::TetraMesh box = BoxMesh({22, 22, 22}, {-50, -50, -50}, {50, 50, 50}, 0.12);
  Grade(box);
  FixSurface(box);
  const Eigen::Vector3d force_n(0.004, -0.006, 0.01);
  std::vector<SmallForce> forces;
  constexpr int kParts = 8;
  for (int i = 0; i < kParts * kParts * kParts; ++i) {
    const Eigen::Vector3d cell(i % kParts, i / kParts % kParts, i / (kParts * kParts));
    forces.push_back({kHalfMm * ((2.0 * cell.array() + 1.0) / kParts - 1.0).matrix(),
                      force_n / (kParts * kParts * kParts)});
  }
  // The same force on the nodes, spread as the shape functions have it at the same places.
  Eigen::Matrix3Xd load = Eigen::Matrix3Xd::Zero(3, box.nodes_mm.cols());
  const mesh::PointLocation location(box);
  for (const SmallForce& f : forces) {
    const auto found = location.Find(f.at_mm);
    ASSERT_TRUE(found);
    for (int c = 0; c < 4; ++c) {
      load.col(box.tetrahedra(c, found->tetrahedron)) += found->weights[c] * f.force_n;
    }
  }
  for (const ElementKind kind : kBothElements) {
    for (const double nu : {0.3, 0.499}) {
      if (kind == ElementKind::kLinear && nu > 0.45) continue;  // Locks.
      const ElasticTissue tissue{0.01, nu};
      const Eigen::Matrix3Xd exact = AtNodes(box, [&](const Eigen::Vector3d& x) {
        return x.norm() < 2.0 * kHalfMm ? Eigen::Vector3d(0, 0, 0) : KelvinMm(forces, x, tissue);
      });
      const StaticSolver solver(box, UniformTable(0.01, nu), kind);
      const Eigen::Matrix3Xd u = solver.Displacements(load, exact);
      ExpectWithin3Percent(AwayFromTheLoad(box, u, exact), kind, nu);
    }
  }
}

}  // namespace
}  // namespace acus::mechanics
