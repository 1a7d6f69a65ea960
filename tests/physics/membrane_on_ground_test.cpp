// A membrane on soft tissue, pressed in: finite elements against the integral of a plate on a half
// space.
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <tuple>

#include "acus/physics/tissue/contact_system.h"
#include "acus/physics/tissue/tip_kernel.h"
#include "support/elastic_box.h"

namespace acus::tissue {
namespace {

constexpr double kRadiusMm = 8.0;

/// Displacement of a disc of 8 mm under 1 N on it, in a box of half a metre with bricks that grow
/// outwards from `element_mm`.
double DiscMmPerN(double element_mm, const mechanics::Membrane& membrane,
                  const mechanics::ElasticTissue& ground) {
  const int cells = 2 * static_cast<int>(std::lround(12.0 / element_mm)) + 20;
  mesh::TetraMesh mesh =
      testing_support::BoxMesh({cells, cells, cells / 2}, {-1, -1, -1}, {1, 1, 0}, 0.1);
  // From the unit box to millimetres: even within the kernel, geometric beyond.
  const int even = (cells - 20) / 2;
  const auto stretched = [&](double s) {
    const double n = std::abs(s) * 0.5 * cells;  // Cells from the middle.
    double x = element_mm * n;
    if (n > even) {
      const double growth = 1.45;
      x = element_mm * (even + (std::pow(growth, n - even) - 1.0) / (growth - 1.0) * growth);
    }
    return std::copysign(x, s);
  };
  for (Eigen::Index i = 0; i < mesh.nodes_mm.cols(); ++i) {
    for (int d = 0; d < 3; ++d) mesh.nodes_mm(d, i) = stretched(mesh.nodes_mm(d, i));
  }
  const double side_mm = mesh.nodes_mm.maxCoeff(), floor_mm = mesh.nodes_mm.row(2).minCoeff();
  testing_support::Fix(mesh, [&](const Eigen::Vector3d& x) {
    return x.z() < floor_mm + 1e-6 || x.head<2>().cwiseAbs().maxCoeff() > side_mm - 1e-6;
  });
  mechanics::ElasticityTable table = testing_support::ElasticLabels({{4, ground}});
  table.membranes.push_back(membrane);
  const auto compliance = testing_support::CondensedOf(mesh, table, [&](const Eigen::Vector3d& x) {
    return x.z() > -1e-9 && x.norm() < kRadiusMm + 1.0;
  });
  const TipKernel kernel(mesh, compliance);
  const ContactSystem system(compliance, {.points = 1, .slots = 0});
  const KernelPlace disc = kernel.Disc({0.2, -0.3, 0.0}, kRadiusMm);
  return system.Between(disc.place, disc.place)(2, 2);
}

TEST(MembraneOnGround, MovesAsAPlateInTensionOnAHalfSpace) {
  const mechanics::ElasticTissue ground{0.01, 0.49};
  mechanics::Membrane membrane;
  membrane.tissue = 4;
  membrane.against.set(0);
  membrane.poissons_ratio = 0.4;
  for (const auto& [modulus, thickness, tension] :
       {std::tuple(0.13, 2.0, 0.0), std::tuple(0.13, 2.0, 0.05), std::tuple(1.0, 0.1, 0.1)}) {
    membrane.youngs_modulus_mpa = modulus;
    membrane.thickness_mm = thickness;
    membrane.tension_n_per_mm = tension;
    const double exact = mechanics::MembraneComplianceMmPerN(membrane, ground.ShearModulusMpa(),
                                                             ground.poissons_ratio, kRadiusMm);
    const double coarse = DiscMmPerN(4.0, membrane, ground) / exact;
    const double fine = DiscMmPerN(2.0, membrane, ground) / exact;
    std::printf("E %.2f MPa, t %.1f mm, T %.2f N/mm: 4 mm %.3f, 2 mm %.3f of the half space\n",
                modulus, thickness, tension, coarse, fine);
    EXPECT_NEAR(coarse, 1.0, 0.09) << modulus << " " << tension;
    EXPECT_NEAR(fine, 1.0, 0.09) << modulus << " " << tension;
  }
}

}  // namespace
}  // namespace acus::tissue
