// Large strain against closed forms: a bar that is pulled, layers, and displacements that were
// chosen first.
#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/error.h"
#include "references/finite_strain.h"
#include "support/box_mesh.h"
#include "support/elastic_loads.h"

namespace acus::mechanics {
namespace {

using namespace testing_support;

constexpr double kYoungsMpa = 0.006;

const HyperelasticLaw kLaws[] = {
    {LawKind::kNeoHookean},
    {LawKind::kYeoh, 1e-3, 4e-4, 0.0},
    {LawKind::kFung, 0.0, 0.0, 1.5},
    {.kind = LawKind::kKnowles, .exponent_b = 5.0, .power_n = 0.7},
    {.kind = LawKind::kOgden, .ogden = {{{0.6, -3.0}, {0.4, 4.0}}}},
    {.kind = LawKind::kNeoHookean, .fibres = {1e-3, 0.02, Eigen::Vector3d::UnitZ()}}};

ElasticityTable TableOf(const HyperelasticLaw& law, double poissons_ratio) {
  ElasticityTable table = UniformTable(kYoungsMpa, poissons_ratio);
  table.law.fill(law);
  return table;
}

/// Principal nominal stresses of the law at principal stretches, from its definition.
Eigen::Vector3d NominalStress(const HyperelasticLaw& law, const ElasticTissue& tissue,
                              const Eigen::Vector3d& stretch) {
  const double j = stretch.prod();
  const double i1 = std::pow(j, -2.0 / 3.0) * stretch.squaredNorm();
  const double x = i1 - 3.0;
  const double mu = tissue.ShearModulusMpa();
  const double root = std::cbrt(j);
  double slope = 0.5 * mu;
  if (law.kind == LawKind::kYeoh) slope += 2.0 * law.c2_mpa * x + 3.0 * law.c3_mpa * x * x;
  if (law.kind == LawKind::kFung) slope *= std::exp(law.exponent_b * x);
  if (law.kind == LawKind::kKnowles) {
    slope *= std::pow(1.0 + law.exponent_b * x / law.power_n, law.power_n - 1.0);
  }
  const double e = std::max(0.0, std::pow(stretch[2] / root, 2) - 1.0);  // Of fibres along z.
  const double fibre = law.fibres.k1_mpa * e * std::exp(law.fibres.k2 * e * e);
  const double pressure = tissue.BulkModulusMpa() * (j - 1.0);
  Eigen::Vector3d out;
  for (int k = 0; k < 3; ++k) {
    const double by_stretch =
        2.0 * std::pow(j, -2.0 / 3.0) * stretch[k] - 2.0 / 3.0 * i1 / stretch[k];
    out[k] = slope * by_stretch + pressure * j / stretch[k];
    if (law.kind == LawKind::kOgden) {
      out[k] = pressure * j / stretch[k];
      for (const OgdenTerm& term : law.ogden) {
        const Eigen::Array3d power = (stretch / root).array().pow(term.exponent);
        out[k] += 2.0 * mu * term.share / term.exponent * (power[k] - power.mean()) / stretch[k];
      }
    }
    const double along = k == 2 ? 1.0 : 0.0;
    out[k] += 2.0 * fibre * std::pow(stretch[2] / root, 2) * (along - 1.0 / 3.0) / stretch[k];
  }
  return out;
}

/// The stretch across a bar that is stretched by `along` and free at its sides: bisection.
double StretchAcross(const HyperelasticLaw& law, const ElasticTissue& tissue, double along) {
  double low = 0.05, high = 3.0;
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (low + high);
    (NominalStress(law, tissue, {middle, middle, along})[0] > 0.0 ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

class LargeStrain : public testing::TestWithParam<ElementKind> {};
INSTANTIATE_TEST_SUITE_P(Elements, LargeStrain, testing::ValuesIn(kBothElements));

TEST_P(LargeStrain, APulledBarHasTheForceOfItsLaw) {
  for (const HyperelasticLaw& law : kLaws) {
    mesh::TetraMesh bar = BoxMesh({3, 3, 4}, {0, 0, 0}, {10, 10, 20}, 0.15);
    Fix(bar, [](const Eigen::Vector3d& x) { return x.z() == 0.0 || x.z() == 20.0; });
    const ElasticTissue tissue{kYoungsMpa, 0.49};
    FiniteStrainSolver solver(bar, TableOf(law, 0.49), GetParam());
    for (const double along : {0.6, 0.8, 1.3, 1.8, 2.4}) {
      const double across = StretchAcross(law, tissue, along);
      const Eigen::Vector3d stretch(across, across, along);
      const Eigen::Matrix3Xd exact = stretch.asDiagonal() * bar.nodes_mm - bar.nodes_mm;
      const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, exact.cols());
      // In two steps: a start at rest may end in another equilibrium, with elements inside out.
      const FiniteStrainSolution half = solver.Solve(none, 0.5 * exact);
      const FiniteStrainSolution solution = solver.Solve(none, exact, half.displacement_mm);
      EXPECT_LT((solution.displacement_mm - exact).norm(), 1e-7 * exact.norm())
          << LawName(law.kind) << " " << along;
      const Eigen::Matrix3Xd force_n = solver.Forces(solution.displacement_mm);
      double on_top_n = 0.0;
      for (Eigen::Index i = 0; i < force_n.cols(); ++i) {
        if (bar.nodes_mm(2, i) == 20.0) on_top_n += force_n(2, i);
      }
      const double want_n = 100.0 * NominalStress(law, tissue, stretch)[2];
      EXPECT_NEAR(on_top_n / want_n, 1.0, 1e-7) << LawName(law.kind) << " " << along;
    }
  }
}

TEST_P(LargeStrain, AFreeBarFindsItsOwnWidth) {
  const HyperelasticLaw law = kLaws[2];
  const ElasticTissue tissue{kYoungsMpa, 0.45};
  mesh::TetraMesh bar = BoxMesh({2, 2, 4}, {0, 0, 0}, {10, 10, 20}, 0.15);
  // One node holds x and y; the ends are pulled by tractions that keep their direction.
  Fix(bar, [](const Eigen::Vector3d& x) {
    return x.norm() == 0.0 || x == Eigen::Vector3d(10, 0, 0) || x == Eigen::Vector3d(0, 10, 0);
  });
  const double along = 1.5;
  const double across = StretchAcross(law, tissue, along);
  const Eigen::Vector3d stretch(across, across, along);
  const double stress_mpa = NominalStress(law, tissue, stretch)[2];
  const auto end = [](const Eigen::Vector3d& x) { return x.z() == 0.0 || x.z() == 20.0; };
  const Eigen::Matrix3Xd load = TractionLoad(bar, end, [&](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(0, 0, x.z() == 0.0 ? -stress_mpa : stress_mpa);
  });
  const Eigen::Matrix3Xd exact = stretch.asDiagonal() * bar.nodes_mm - bar.nodes_mm;
  FiniteStrainSolver solver(bar, TableOf(law, 0.45), GetParam());
  // The three held nodes go where the closed form has them: they need no force.
  const FiniteStrainSolution solution = solver.Solve(load, exact);
  EXPECT_LT((solution.displacement_mm - exact).norm(), 1e-6 * exact.norm());
}

TEST_P(LargeStrain, LayersOfOneToThirtyEachHaveTheirConstantStrain) {
  mesh::TetraMesh box = BoxMesh({2, 2, 4}, {0, 0, 0}, {10, 10, 20}, 0.0);
  FixSurface(box);
  for (std::size_t t = 0; t < box.tissue.size(); ++t) {
    double z = 0.0;
    for (int c = 0; c < 4; ++c) z += 0.25 * box.nodes_mm(2, box.tetrahedra(c, static_cast<int>(t)));
    box.tissue[t] = z > 10.0 ? 2 : 1;
  }
  ElasticityTable table = TableOf(kLaws[2], 0.45);
  table.tissue[2] = {30.0 * kYoungsMpa, 0.45};
  // Pressed along z with the sides held: the same nominal stress in both layers.
  const double soft = 0.8;
  const auto stress = [&](int tissue, double along) {
    return NominalStress(kLaws[2], table.tissue[static_cast<std::size_t>(tissue)],
                         {1, 1, along})[2];
  };
  double low = 0.7, high = 1.0;
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (low + high);
    (stress(2, middle) > stress(1, soft) ? high : low) = middle;
  }
  const Eigen::Matrix3Xd exact = AtNodes(box, [&](const Eigen::Vector3d& x) {
    const double above = std::max(0.0, x.z() - 10.0);
    return Eigen::Vector3d(0, 0, (soft - 1.0) * (x.z() - above) + (low - 1.0) * above);
  });
  FiniteStrainSolver solver(box, table, GetParam());
  const FiniteStrainSolution solution =
      solver.Solve(Eigen::Matrix3Xd::Zero(3, exact.cols()), exact);
  EXPECT_LT((solution.displacement_mm - exact).norm(), 1e-7 * exact.norm());
}

/// u_i = a_i sin(k_i . x + p_i) of large strain, and the force per volume that holds it: -Div P, by
/// differences of the closed form of P.
struct LargeWaves {
  HyperelasticLaw law;
  ElasticTissue tissue;
  Eigen::Matrix3d wave = (Eigen::Matrix3d() << 0, 2.0, -1.0, 1.5, 0, 2.0, 2.0, -1.5, 0).finished();
  Eigen::Vector3d height_mm{0.12, -0.1, 0.11};
  Eigen::Vector3d phase{0.3, 0.1, -0.2};

  Eigen::Vector3d At(const Eigen::Vector3d& x) const {
    return (height_mm.array() * (wave * x + phase).array().sin()).matrix();
  }
  Eigen::Matrix3d Stress(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d slope = (height_mm.array() * (wave * x + phase).array().cos()).matrix();
    const Eigen::Matrix3d f = Eigen::Matrix3d::Identity() + slope.asDiagonal() * wave;
    return ShapeStressMpa(law, tissue.ShearModulusMpa(), f) +
           tissue.BulkModulusMpa() * (f.determinant() - 1.0) * Cofactor(f);
  }
  Eigen::Vector3d ForceDensity(const Eigen::Vector3d& x) const {
    const double h = 1e-5;
    Eigen::Vector3d out = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = h * Eigen::Vector3d::Unit(k);
      out -= (Stress(x + d) - Stress(x - d)).col(k) / (2.0 * h);
    }
    return out;
  }
};

double ErrorWith(int cells, ElementKind kind, const LargeWaves& waves) {
  mesh::TetraMesh box = BoxMesh({cells, cells, cells}, {0, 0, 0}, {1, 1, 1}, 0.15, 5);
  FixSurface(box);
  const auto exact = [&](const Eigen::Vector3d& x) { return waves.At(x); };
  const Eigen::Matrix3Xd load =
      BodyLoad(box, [&](const Eigen::Vector3d& x) { return waves.ForceDensity(x); });
  FiniteStrainSolver solver(box, TableOf(waves.law, waves.tissue.poissons_ratio), kind);
  const Eigen::Matrix3Xd at_nodes = AtNodes(box, exact);
  return RelativeL2Error(box, solver.Solve(load, at_nodes, at_nodes).displacement_mm, exact);
}

double OrderOf(ElementKind kind, const LargeWaves& waves) {
  const double coarse = ErrorWith(8, kind, waves);
  const double fine = ErrorWith(16, kind, waves);
  EXPECT_LT(fine, 0.02);
  return std::log2(coarse / fine);
}

TEST(FiniteStrainConvergence, LinearElementsAreOfSecondOrder) {
  EXPECT_GE(OrderOf(ElementKind::kLinear, {kLaws[2], {kYoungsMpa, 0.3}}), 1.9);
}

TEST(FiniteStrainConvergence, AveragedVolumeIsOfSecondOrder) {
  EXPECT_GE(OrderOf(ElementKind::kAveragedDilatation, {kLaws[2], {kYoungsMpa, 0.3}}), 1.9);
}

TEST(FiniteStrainConvergence, AveragedVolumeIsOfSecondOrderWhenNearlyIncompressible) {
  for (const double nu : {0.49, 0.499}) {
    LargeWaves waves{kLaws[2], {kYoungsMpa, nu}};
    // One shear after another: the volume is kept at any height.
    waves.wave << 0, 3.0, -2.0, 0, 0, 3.0, 0, 0, 0;
    waves.height_mm = {0.2, -0.2, 0.0};
    EXPECT_GE(OrderOf(ElementKind::kAveragedDilatation, waves), 1.9) << nu;
  }
}

}  // namespace
}  // namespace acus::mechanics
