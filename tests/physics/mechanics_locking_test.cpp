// Pressure on a patch of a block of nearly incompressible tissue: how far it is pressed in.
#include <gtest/gtest.h>
#include <memory>

#include "references/static_solver.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

/// Mean depression under 1 N on 20 x 20 mm of a cube of 100 mm and 10 kPa, held at its bottom.
struct Reference {
  double poissons_ratio;
  double
      mean_mm;  ///< Quadratic tetrahedra on 10^3, 14^3 and 18^3 x 6 graded elements, extrapolated.
};
constexpr Reference kReferences[] = {{0.49, 3.62}, {0.499, 3.58}, {0.4999, 3.57}};

class PressedCube {
 public:
  explicit PressedCube(int cells)
      : cube_(BoxMesh({cells, cells, cells}, {0, 0, 0}, {100, 100, 100}, 0.15)) {
    Fix(cube_, [](const Eigen::Vector3d& x) { return x.z() == 0.0; });
    load_ = TractionLoad(
        cube_, [](const Eigen::Vector3d& x) { return x.z() == 100.0; },
        [](const Eigen::Vector3d& x) {
          const bool is_on = std::abs(x.x() - 50.0) < 10.0 && std::abs(x.y() - 50.0) < 10.0;
          return Eigen::Vector3d(0, 0, is_on ? -1.0 : 0.0);
        },
        32);
    load_ /= load_.row(2).cwiseAbs().sum();
  }
  double MeanDepressionMm(ElementKind kind, double poissons_ratio) const {
    const StaticSolver solver(cube_, UniformTable(0.01, poissons_ratio), kind);
    return load_.cwiseProduct(solver.Displacements(load_)).sum();
  }

 private:
  mesh::TetraMesh cube_;
  Eigen::Matrix3Xd load_;
};

TEST(MechanicsLocking, AveragedDilatationIsWithin5PercentOn27000Nodes) {
  const PressedCube cube(29);
  for (const auto& [nu, mean_mm] : kReferences) {
    const double error =
        cube.MeanDepressionMm(ElementKind::kAveragedDilatation, nu) / mean_mm - 1.0;
    RecordProperty("nu_" + std::to_string(nu), testing::PrintToString(error));
    EXPECT_LT(std::abs(error), 0.05) << nu;
  }
}

TEST(MechanicsLocking, PlainLinearElementsLock) {
  const PressedCube cube(14);
  EXPECT_LT(cube.MeanDepressionMm(ElementKind::kLinear, 0.499), 0.6 * 3.58);
  const double averaged_mm = cube.MeanDepressionMm(ElementKind::kAveragedDilatation, 0.499);
  EXPECT_NEAR(averaged_mm / 3.58, 1.0, 0.1);  // Even on 3000 nodes.
}

}  // namespace
}  // namespace acus::mechanics
