// Forces on a needle do not depend on the mesh: held against closed forms and finer meshes.
#include <cmath>
#include <gtest/gtest.h>
#include <numbers>

#include "acus/physics/tissue/contact_mesh.h"
#include "acus/physics/tissue/contact_system.h"
#include "acus/physics/tissue/local_compliance.h"
#include "acus/physics/tissue/tip_kernel.h"
#include "support/elastic_box.h"

namespace acus::tissue {
namespace {

using testing_support::BoxMesh;
using testing_support::ElasticLabels;

constexpr double kTubeMm = 15.0;
constexpr double kWireMm = 0.4;
constexpr int kPlaces = 4;

/// A tube of 15 mm radius and 60 mm length with a rigid wall; squares across become circles.
mesh::TetraMesh Tube(int cells) {
  const int along = static_cast<int>(60.0 / (2.0 * kTubeMm / cells));
  mesh::TetraMesh mesh =
      BoxMesh({cells, cells, along}, {-kTubeMm, -kTubeMm, 0.0}, {kTubeMm, kTubeMm, 60.0}, 0.15);
  for (Eigen::Index i = 0; i < mesh.nodes_mm.cols(); ++i) {
    const Eigen::Vector2d x = mesh.nodes_mm.col(i).head<2>();
    if (x.isZero()) continue;
    const double square = x.cwiseAbs().maxCoeff();
    const double t = square / kTubeMm;
    mesh.nodes_mm.col(i).head<2>() *= (1.0 - t * t) + t * t * square / x.norm();
  }
  testing_support::Fix(
      mesh, [](const Eigen::Vector3d& x) { return x.head<2>().norm() > kTubeMm - 1e-6; });
  return mesh;
}

struct WireForce {
  double axial_n_per_mm2 = 0.0;
  double lateral_n_per_mm2 = 0.0;
};

/// Force per mm of a stuck wire in its middle third, per mm that it is moved along or across.
WireForce ForceOnWire(int cells, double poissons_ratio, double spacing_mm) {
  const mechanics::ElasticTissue tissue{0.02, poissons_ratio};
  const mesh::TetraMesh mesh = Tube(cells);
  const double cell_mm = 2.0 * kTubeMm / cells;
  const auto compliance = testing_support::ComplianceOf(
      mesh, ElasticLabels({{4, tissue}}), mechanics::Storage::kDouble,
      [&](const Eigen::Vector3d& x) { return x.head<2>().norm() < 1.0 + 1.8 * cell_mm; },
      mechanics::ElementKind::kAveragedDilatation);
  const ContactMesh places(mesh, compliance);
  const int points = static_cast<int>(60.0 / spacing_mm);
  const ContactSystem system(compliance, {.points = points, .slots = 0});
  Eigen::Matrix3d down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  WireForce mean;
  for (int place = 0; place < kPlaces * kPlaces; ++place) {  // All over a cell.
    const Eigen::Vector2d offset =
        (Eigen::Vector2d(place % kPlaces, place / kPlaces).array() + 0.5) / kPlaces - 0.5;
    ContactState state = system.NewState();
    system.Restart(state, down);
    for (int p = 0; p < points; ++p) {
      const Spot spot = places.Find(
          {offset.x() * cell_mm, offset.y() * cell_mm, 59.99 - (p + 0.45) * spacing_mm});
      system.AppendPoint(state, spot.place,
                         ShaftCompliance(tissue, spot.element_mm, kWireMm, spacing_mm));
    }
    for (const int direction : {0, 2}) {
      for (int p = 0; p < points; ++p) {
        state.SetLateral(p, direction == 0 ? 1.0 : 0.0, 0.0);
        const double bound_n = direction == 2 ? 1e9 : 0.0;
        state.SetPointAxial(p, direction == 2 ? 1.0 : 0.0, -bound_n, bound_n);
      }
      system.Solve(state);
      double sum_n = 0.0;
      for (int p = points / 3; p < points - points / 3; ++p)
        sum_n += state.PointForceN(p)[direction];
      const double length_mm = (points - 2 * (points / 3)) * spacing_mm;
      (direction == 2 ? mean.axial_n_per_mm2 : mean.lateral_n_per_mm2) +=
          sum_n / (length_mm * kPlaces * kPlaces);
    }
  }
  return mean;
}

/// A rigid wire of radius r on the axis of a rigid tube of radius R. Along: 2 pi G / ln(R/r).
/// Across, plane strain: 8 pi G (1-nu) / (k ln(R/r) - (R^2-r^2) / (k (R^2+r^2))), k = 3 - 4 nu.
WireForce ClosedForm(double poissons_ratio) {
  const double shear_mpa = 0.02 / (2.0 * (1.0 + poissons_ratio));
  const double logarithm = std::log(kTubeMm / kWireMm);
  const double k = 3.0 - 4.0 * poissons_ratio;
  const double r2 = kWireMm * kWireMm;
  const double tube2 = kTubeMm * kTubeMm;
  return {2.0 * std::numbers::pi * shear_mpa / logarithm,
          8.0 * std::numbers::pi * shear_mpa * (1.0 - poissons_ratio) /
              (k * logarithm - (tube2 - r2) / (k * (tube2 + r2)))};
}

TEST(NeedleInMesh, AWireInATubeFeelsTheClosedFormInEveryMesh) {
  for (const double nu : {0.3, 0.45, 0.49}) {
    const WireForce exact = ClosedForm(nu);
    for (const int cells : {6, 7, 8}) {
      const WireForce found = ForceOnWire(cells, nu, 1.0);
      const double axial = found.axial_n_per_mm2 / exact.axial_n_per_mm2 - 1.0;
      const double lateral = found.lateral_n_per_mm2 / exact.lateral_n_per_mm2 - 1.0;
      std::printf("nu %.2f, cells of %.2f mm: axial %+.2f %%, lateral %+.2f %%\n", nu, 30.0 / cells,
                  100.0 * axial, 100.0 * lateral);
      EXPECT_NEAR(axial, 0.0, 0.02);
      EXPECT_NEAR(lateral, 0.0, 0.04);
    }
  }
}

TEST(NeedleInMesh, ManyPointsInOneElementGiveTheSameForce) {
  // Elements of 4 mm, points every 0.4 to 2 mm.
  const WireForce coarse = ForceOnWire(8, 0.45, 2.0);
  for (const double spacing_mm : {1.0, 0.5, 0.4}) {
    const WireForce fine = ForceOnWire(8, 0.45, spacing_mm);
    EXPECT_NEAR(fine.axial_n_per_mm2 / coarse.axial_n_per_mm2, 1.0, 0.01) << spacing_mm;
    EXPECT_NEAR(fine.lateral_n_per_mm2 / coarse.lateral_n_per_mm2, 1.0, 0.02) << spacing_mm;
  }
}

/// How far 1 N moves the tip, with a lump of this radius, in a box of 60 mm.
double TipMmPerN(int cells, double lump_mm, bool on_surface) {
  const mechanics::ElasticTissue tissue{0.02, 0.45};
  mesh::TetraMesh mesh = BoxMesh({cells, cells, cells}, {-30, -30, 0}, {30, 30, 60}, 0.0);
  testing_support::Fix(mesh, [](const Eigen::Vector3d& x) {
    return x.z() < 1e-6 || x.head<2>().cwiseAbs().maxCoeff() > 30.0 - 1e-6;
  });
  const double cell_mm = 60.0 / cells;
  const Eigen::Vector3d centre(0, 0, on_surface ? 60.0 : 30.0);
  const auto compliance = testing_support::CondensedOf(
      mesh, ElasticLabels({{4, tissue}}),
      [&](const Eigen::Vector3d& x) { return (x - centre).norm() < 12.0 + 1.0 * cell_mm; });
  const ContactMesh places(mesh, compliance);
  const TipKernel kernel(mesh, compliance);
  const ContactSystem system(compliance, {.points = 1, .slots = 0});
  const double near_mm2_per_n =
      on_surface ? PunchMobilityMm2PerN(tissue) : SphereMobilityMm2PerN(tissue);
  double sum = 0.0;
  const Eigen::Vector3d offsets[] = {{0.1, 0.2, -0.1}, {0.4, 0.3, -0.45}, {-0.3, 0.15, -0.25}};
  for (const Eigen::Vector3d& offset : offsets) {
    Eigen::Vector3d at = centre + cell_mm * offset;
    if (on_surface) at.z() = 60.0 - 1e-6;
    const double element_mm = places.Find(at).element_mm;
    const double radius_mm = KernelRadiusMm(element_mm, lump_mm);
    const KernelPlace ball = kernel.Ball(at, radius_mm);
    sum += (system.Between(ball.place, ball.place)(2, 2) +
            near_mm2_per_n * NearFieldPerMm(radius_mm, lump_mm) +
            SphereMobilityMm2PerN(tissue) * ball.self_per_mm) /
           3.0;
  }
  return sum;
}

TEST(NeedleInMesh, TheTipMovesTheSameInEveryMesh) {
  for (const double lump_mm : {1.0, 2.5, 4.0}) {
    EXPECT_NEAR(TipMmPerN(8, lump_mm, false) / TipMmPerN(12, lump_mm, false), 1.0, 0.02) << lump_mm;
    EXPECT_NEAR(TipMmPerN(8, lump_mm, true) / TipMmPerN(12, lump_mm, true), 1.0, 0.08) << lump_mm;
    EXPECT_NEAR(TipMmPerN(12, lump_mm, false) / TipMmPerN(18, lump_mm, false), 1.0, 0.03)
        << lump_mm;
    EXPECT_NEAR(TipMmPerN(12, lump_mm, true) / TipMmPerN(18, lump_mm, true), 1.0, 0.1) << lump_mm;
  }
  // A rigid sphere of 1 mm in an infinite solid; the box of 60 mm is 4 % stiffer.
  const double shear_mpa = 0.02 / 2.9;
  EXPECT_NEAR(TipMmPerN(12, 1.0, false) / (2.3 / (24.0 * std::numbers::pi * shear_mpa * 0.55)),
              0.96, 0.02);
}

}  // namespace
}  // namespace acus::tissue
