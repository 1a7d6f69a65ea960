#include "acus/physics/mechanics/elements/hyperelastic_law.h"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

#include "acus/base/core/random.h"

namespace acus::mechanics {
namespace {

constexpr double kShearMpa = 0.002;
const Fibres kOblique{0.003, 1.4, Eigen::Vector3d(2, -1, 2) / 3.0};
const HyperelasticLaw kLaws[] = {
    {LawKind::kNeoHookean},
    {LawKind::kYeoh, 5e-4, 2e-4, 0.0},
    {LawKind::kYeoh, -2e-4, 2e-4, 0.0},
    {LawKind::kFung, 0.0, 0.0, 1.7},
    {.kind = LawKind::kKnowles, .exponent_b = 40.0, .power_n = 0.6},
    {.kind = LawKind::kOgden, .ogden = {{{1.0, -3.5}}}},
    {.kind = LawKind::kOgden, .ogden = {{{0.7, 9.0}, {0.3, -20.0}}}},
    {.kind = LawKind::kNeoHookean, .fibres = kOblique},
    {.kind = LawKind::kNeoHookean, .fibres = {0.003, 0.0, Eigen::Vector3d::UnitX()}},
    {.kind = LawKind::kOgden, .ogden = {{{1.0, 4.0}}}, .fibres = kOblique}};

class Law : public testing::TestWithParam<HyperelasticLaw> {};
INSTANTIATE_TEST_SUITE_P(Laws, Law, testing::ValuesIn(kLaws));

Eigen::Matrix3d Random(RandomStream& random, double size) {
  Eigen::Matrix3d f = Eigen::Matrix3d::Identity();
  for (double& value : f.reshaped()) value += size * random.Uniform(-1.0, 1.0);
  return f;
}

/// Strained, stretched far, flat and inside out.
std::vector<Eigen::Matrix3d> SomeGradients() {
  RandomStream random(3, "gradients");
  std::vector<Eigen::Matrix3d> out;
  for (const double size : {0.0, 0.05, 0.5, 2.0}) {
    for (int n = 0; n < 5; ++n) out.push_back(Random(random, size));
  }
  out.push_back(Eigen::Vector3d(1, 1, 0).asDiagonal());
  out.push_back(Eigen::Vector3d(1.2, 0.9, -0.4).asDiagonal());
  return out;
}

TEST_P(Law, StressIsTheSlopeOfTheEnergy) {
  for (const Eigen::Matrix3d& f : SomeGradients()) {
    const Eigen::Matrix3d stress = ShapeStressMpa(GetParam(), kShearMpa, f);
    for (int i = 0; i < 9; ++i) {
      const double h = 1e-6;
      const auto energy = [&](double change) {
        Eigen::Matrix3d at = f;
        at(i) += change;
        return ShapeEnergyMpa(GetParam(), kShearMpa, at);
      };
      const double slope =
          (8.0 * (energy(h) - energy(-h)) - (energy(2.0 * h) - energy(-2.0 * h))) / (12.0 * h);
      EXPECT_NEAR(stress(i), slope, 1e-6 * (kShearMpa + stress.norm())) << f;
    }
  }
}

TEST_P(Law, TangentIsTheSlopeOfTheStress) {
  const double pressure_mpa = -0.003;
  const Fibres& fibres = GetParam().fibres;
  for (const Eigen::Matrix3d& f : SomeGradients()) {
    // Fibres that are just taut have another tangent on either side.
    if (fibres.k1_mpa > 0.0 && f == Eigen::Matrix3d::Identity()) continue;
    const Matrix9 tangent = ShapeTangentMpa(GetParam(), kShearMpa, f, pressure_mpa);
    const auto stress = [&](const Eigen::Matrix3d& at) -> Eigen::Matrix3d {
      return ShapeStressMpa(GetParam(), kShearMpa, at) + pressure_mpa * Cofactor(at);
    };
    for (int i = 0; i < 9; ++i) {
      const double h = 1e-6;
      Eigen::Matrix3d up = f, down = f;
      up(i) += h;
      down(i) -= h;
      const Eigen::Matrix3d slope = (stress(up) - stress(down)) / (2.0 * h);
      const Eigen::Matrix3d column = tangent.col(i).reshaped(3, 3);
      EXPECT_LT((column - slope).norm(), 1e-5 * (kShearMpa + tangent.norm())) << f;
    }
  }
}

TEST_P(Law, RotationCostsNothingAndTurnsTheStress) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(1.9, Eigen::Vector3d(2, -1, 1).normalized()).toRotationMatrix();
  for (const Eigen::Matrix3d& f : SomeGradients()) {
    const double energy = ShapeEnergyMpa(GetParam(), kShearMpa, f);
    EXPECT_NEAR(ShapeEnergyMpa(GetParam(), kShearMpa, turn * f), energy,
                1e-12 * (kShearMpa + std::abs(energy)));
    const Eigen::Matrix3d stress = ShapeStressMpa(GetParam(), kShearMpa, f);
    EXPECT_LT((ShapeStressMpa(GetParam(), kShearMpa, turn * f) - turn * stress).norm(),
              1e-12 * (kShearMpa + stress.norm()));
  }
}

TEST_P(Law, IsTheLinearModelAtSmallStrain) {
  const Fibres& fibres = GetParam().fibres;
  Eigen::Matrix3d strain;
  strain << 1.0, 0.4, -0.3, 0.4, -0.7, 0.2, -0.3, 0.2, 0.5;
  strain *= 1e-7;
  const Eigen::Matrix3d stress =
      ShapeStressMpa(GetParam(), kShearMpa, Eigen::Matrix3d::Identity() + strain);
  Eigen::Matrix3d linear = 2.0 * kShearMpa * strain;
  linear.diagonal().array() -= 2.0 / 3.0 * kShearMpa * strain.trace();
  if (fibres.k1_mpa > 0.0) {  // 4 k1 e along them, without a part that changes the volume.
    const Eigen::Vector3d& a = fibres.direction_in_ct;
    const double along = a.dot(strain * a) - strain.trace() / 3.0;
    const Eigen::Matrix3d pull = 4.0 * fibres.k1_mpa * std::max(0.0, along) * a * a.transpose();
    linear += pull - pull.trace() / 3.0 * Eigen::Matrix3d::Identity();
  }
  EXPECT_LT((stress - linear).norm(), 1e-6 * linear.norm());
}

TEST_P(Law, IsFiniteAtEveryFiniteGradient) {
  RandomStream random(5, "extreme");
  for (const double size : {1e-30, 1e-3, 1.0, 1e3, 1e9, 1e15}) {
    for (int n = 0; n < 20; ++n) {
      const Eigen::Matrix3d f = size * Random(random, 3.0);
      EXPECT_TRUE(std::isfinite(ShapeEnergyMpa(GetParam(), kShearMpa, f))) << f;
      EXPECT_TRUE(ShapeStressMpa(GetParam(), kShearMpa, f).allFinite()) << f;
    }
  }
}

TEST_P(Law, EnergyAndSlopesJoinWhereTheyAreContinued) {
  if (GetParam().kind == LawKind::kOgden) return;  // See AStretchIsContinued.
  const double end = GetParam().kind == LawKind::kFung ? std::log(1000.0) / 1.7 : 50.0;
  for (const double x : {0.0, end}) {
    const LawAt below = ValueOf(GetParam(), kShearMpa, x - 1e-9);
    const LawAt above = ValueOf(GetParam(), kShearMpa, x + 1e-9);
    EXPECT_NEAR(above.energy_mpa, below.energy_mpa, 1e-6 * (kShearMpa + below.energy_mpa));
    EXPECT_NEAR(above.slope_mpa, below.slope_mpa, 1e-6 * (kShearMpa + below.slope_mpa));
  }
  const VolumeFactor below = VolumeFactorAt(kLeastJ - 1e-10);
  const VolumeFactor above = VolumeFactorAt(kLeastJ + 1e-10);
  EXPECT_NEAR(above.value, below.value, 1e-7);
  EXPECT_NEAR(above.slope / below.slope, 1.0, 1e-7);
  EXPECT_NEAR(above.curvature / below.curvature, 1.0, 1e-7);
}

// Beyond 1000 times the stiffness at rest energy and stress go on without a jump.
TEST(HyperelasticLaw, AStretchIsContinued) {
  for (const double exponent : {-20.0, -3.0, 1.5, 6.0, 60.0}) {
    const HyperelasticLaw law{.kind = LawKind::kOgden, .ogden = {{{1.0, exponent}}}};
    double before = 0.0;
    Eigen::Matrix3d stress_before = Eigen::Matrix3d::Zero();
    for (double stretch = 0.2; stretch < 6.0; stretch *= 1.0 + 1e-4) {
      Eigen::Matrix3d f = Eigen::Vector3d(stretch, 1.0 / stretch, 1.0).asDiagonal();
      const double energy = ShapeEnergyMpa(law, kShearMpa, f);
      const Eigen::Matrix3d stress = ShapeStressMpa(law, kShearMpa, f);
      if (before > 0.0) {
        EXPECT_NEAR(energy / before, 1.0, 0.02) << exponent << " " << stretch;
        EXPECT_LT((stress - stress_before).norm(), 0.02 * (kShearMpa + stress.norm()));
      }
      before = std::abs(stretch - 1.0) > 0.05 ? energy : 0.0;
      stress_before = stress;
    }
  }
}

// W = sum of 2 mu / a^2 (s^a - 1): Ogden's own form, and the neo-Hookean solid for a = 2.
TEST(HyperelasticLaw, OgdensLawIsItsDefinition) {
  RandomStream random(11, "ogden");
  for (int n = 0; n < 50; ++n) {
    const Eigen::Matrix3d f = Random(random, 0.2);
    const Eigen::Vector3d stretch = std::pow(f.determinant(), -1.0 / 3.0) *
                                    Eigen::JacobiSVD<Eigen::Matrix3d>(f).singularValues();
    for (const double exponent : {-8.0, -2.0, 2.0, 5.0}) {
      const HyperelasticLaw law{.kind = LawKind::kOgden, .ogden = {{{1.0, exponent}}}};
      double want = 0.0;
      for (const double s : stretch) want += std::pow(s, exponent) - 1.0;
      want *= 2.0 * kShearMpa / (exponent * exponent);
      EXPECT_NEAR(ShapeEnergyMpa(law, kShearMpa, f), want, 1e-12 * (kShearMpa + want));
      if (exponent == 2.0) {
        EXPECT_NEAR(want, ShapeEnergyMpa({}, kShearMpa, f), 1e-14);
      }
    }
  }
}

// A wave of any direction and polarisation gets through: no band in which the tissue lets go.
TEST_P(Law, IsEllipticUnderModerateStrain) {
  if (GetParam().c2_mpa < 0.0) return;  // Softens by its own parameters; tables limit it.
  RandomStream random(13, "waves");
  for (int n = 0; n < 200; ++n) {
    Eigen::Matrix3d f = Random(random, 0.25);
    f /= std::cbrt(f.determinant());
    const Matrix9 tangent = ShapeTangentMpa(GetParam(), kShearMpa, f, 0.0);
    Eigen::Vector3d across(random.Normal(), random.Normal(), random.Normal());
    const Eigen::Vector3d normal = (f.transpose() * across).normalized();
    // The polarisation keeps the volume: m . F^-T N = 0.
    Eigen::Vector3d m(random.Normal(), random.Normal(), random.Normal());
    const Eigen::Vector3d c = (f.inverse().transpose() * normal).normalized();
    m = (m - m.dot(c) * c).normalized();
    const Eigen::Matrix3d wave = m * normal.transpose();
    const double stiffness = wave.reshaped().dot(tangent * wave.reshaped());
    EXPECT_GT(stiffness, 0.0) << f;
  }
}

// Compression of what stretches fibres meets none of them.
TEST(HyperelasticLaw, SlackFibresCarryNothing) {
  const Eigen::Vector3d a = kOblique.direction_in_ct;
  const Eigen::Matrix3d shorter = Eigen::Matrix3d::Identity() + (0.8 - 1.0) * a * a.transpose();
  EXPECT_TRUE(FibreStressMpa(kOblique, shorter / std::cbrt(0.8)).isZero());
  const Eigen::Matrix3d longer = Eigen::Matrix3d::Identity() + 0.2 * a * a.transpose();
  const double e = std::pow(1.2, 2) * std::pow(1.2, -2.0 / 3.0) - 1.0;
  EXPECT_NEAR(FibreEnergyMpa(kOblique, longer),
              kOblique.k1_mpa / (2.0 * kOblique.k2) * (std::exp(kOblique.k2 * e * e) - 1.0), 1e-15);
}

TEST(HyperelasticLaw, SaysHowFarItsSlopeFalls) {
  EXPECT_EQ(LeastSlopeShare({LawKind::kFung, 0, 0, 3.0}, kShearMpa), 1.0);
  EXPECT_EQ(LeastSlopeShare({LawKind::kYeoh, 1e-4, 0.0, 0.0}, kShearMpa), 1.0);
  // mu/2 + 2 c2 x + 3 c3 x^2 is least at x = -c2 / (3 c3) = 1/3: 1 - c2^2 / (3 c3) / (mu/2).
  EXPECT_NEAR(LeastSlopeShare({LawKind::kYeoh, -2e-4, 2e-4, 0.0}, kShearMpa),
              1.0 - 4e-8 / 6e-4 / 1e-3, 1e-12);
  EXPECT_LT(LeastSlopeShare({LawKind::kYeoh, -1e-4, 0.0, 0.0}, kShearMpa), 0.0);
}

TEST(HyperelasticLaw, PositivePartKeepsWhatIsPositive) {
  Matrix9 m = Matrix9::Identity();
  m(0, 0) = -3.0;
  Matrix9 want = Matrix9::Identity();
  want(0, 0) = 0.0;
  EXPECT_LT((PositivePart(m) - want).norm(), 1e-12);
}

}  // namespace
}  // namespace acus::mechanics
