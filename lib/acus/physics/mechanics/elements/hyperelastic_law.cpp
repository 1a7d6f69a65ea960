#include "acus/physics/mechanics/elements/hyperelastic_law.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::mechanics {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;

/// Within the range of use.
LawAt Inside(const HyperelasticLaw& law, double half_shear_mpa, double x) {
  switch (law.kind) {
    case LawKind::kNeoHookean:
      break;
    case LawKind::kYeoh:
      return {x * (half_shear_mpa + x * (law.c2_mpa + x * law.c3_mpa)),
              half_shear_mpa + x * (2.0 * law.c2_mpa + 3.0 * law.c3_mpa * x),
              2.0 * law.c2_mpa + 6.0 * law.c3_mpa * x};
    case LawKind::kKnowles: {
      const double n = law.power_n;
      const double base = 1.0 + law.exponent_b * x / n;
      const double slope = half_shear_mpa * std::pow(base, n - 1.0);
      return {half_shear_mpa / law.exponent_b * (std::pow(base, n) - 1.0), slope,
              slope * (n - 1.0) * law.exponent_b / (n * base)};
    }
    case LawKind::kOgden:
      ACUS_ASSERT(false);
    case LawKind::kFung: {
      const double b = law.exponent_b;
      const double growth = std::expm1(b * x);
      return {half_shear_mpa / b * growth, half_shear_mpa * (1.0 + growth),
              half_shear_mpa * b * (1.0 + growth)};
    }
  }
  return {half_shear_mpa * x, half_shear_mpa, 0.0};
}

double EndOfUse(const HyperelasticLaw& law) {
  if (law.kind != LawKind::kFung) return kLargestX;
  return std::min(kLargestX, std::log(kLargestStiffening) / law.exponent_b);
}

}  // namespace

std::string_view LawName(LawKind kind) {
  switch (kind) {
    case LawKind::kYeoh:
      return "yeoh";
    case LawKind::kFung:
      return "fung";
    case LawKind::kKnowles:
      return "knowles";
    case LawKind::kOgden:
      return "ogden";
    case LawKind::kNeoHookean:
      break;
  }
  return "neo_hookean";
}

double LeastSlopeShare(const HyperelasticLaw& law, double shear_modulus_mpa) {
  if (law.kind != LawKind::kYeoh) return 1.0;
  const double half = 0.5 * shear_modulus_mpa;
  const double at_end = Inside(law, half, kLargestX).slope_mpa / half;
  if (law.c2_mpa >= 0.0 || law.c3_mpa <= 0.0) return std::min(1.0, at_end);
  const double x = -law.c2_mpa / (3.0 * law.c3_mpa);
  return Inside(law, half, std::min(x, kLargestX)).slope_mpa / half;
}

LawAt ValueOf(const HyperelasticLaw& law, double shear_modulus_mpa, double x) {
  const double half = 0.5 * shear_modulus_mpa;
  if (x < 0.0) return {half * x, half, 0.0};
  const double end = EndOfUse(law);
  if (x <= end) return Inside(law, half, x);
  const LawAt at = Inside(law, half, end);
  const double over = x - end;
  return {at.energy_mpa + over * (at.slope_mpa + 0.5 * at.curvature_mpa * over),
          at.slope_mpa + at.curvature_mpa * over, at.curvature_mpa};
}

namespace {

double IsotropicEnergyMpa(const HyperelasticLaw& law, double shear_modulus_mpa,
                          const Eigen::Matrix3d& f) {
  if (law.kind == LawKind::kOgden) return OgdenEnergyMpa(law.ogden, shear_modulus_mpa, f);
  const double g = VolumeFactorAt(f.determinant()).value;
  return ValueOf(law, shear_modulus_mpa, g * f.squaredNorm() - 3.0).energy_mpa;
}

Eigen::Matrix3d IsotropicStressMpa(const HyperelasticLaw& law, double shear_modulus_mpa,
                                   const Eigen::Matrix3d& f) {
  if (law.kind == LawKind::kOgden) return OgdenStressMpa(law.ogden, shear_modulus_mpa, f);
  const Eigen::Matrix3d c = Cofactor(f);
  const VolumeFactor g = VolumeFactorAt(f.col(0).dot(c.col(0)));
  const double i1 = f.squaredNorm();
  const double slope = ValueOf(law, shear_modulus_mpa, g.value * i1 - 3.0).slope_mpa;
  return (2.0 * slope * g.value) * f + (slope * g.slope * i1) * c;
}

/// With the pressure's part.
Matrix9 IsotropicTangentMpa(const HyperelasticLaw& law, double shear_modulus_mpa,
                            const Eigen::Matrix3d& f, double pressure_mpa) {
  if (law.kind == LawKind::kOgden) {
    Matrix9 tangent = OgdenTangentMpa(law.ogden, shear_modulus_mpa, f);
    AddDeterminantCurvature(f, pressure_mpa, tangent);
    return tangent;
  }
  const Eigen::Matrix3d cofactor = Cofactor(f);
  const VolumeFactor g = VolumeFactorAt(f.col(0).dot(cofactor.col(0)));
  const double i1 = f.squaredNorm();
  const LawAt w = ValueOf(law, shear_modulus_mpa, g.value * i1 - 3.0);
  const Eigen::Map<const Vector9> fv(f.data());
  const Eigen::Map<const Vector9> cv(cofactor.data());
  const Vector9 x_by_f = 2.0 * g.value * fv + g.slope * i1 * cv;
  Matrix9 out = w.curvature_mpa * x_by_f * x_by_f.transpose();
  out += (2.0 * w.slope_mpa * g.slope) * (fv * cv.transpose() + cv * fv.transpose());
  out += (w.slope_mpa * g.curvature * i1) * cv * cv.transpose();
  out.diagonal().array() += 2.0 * w.slope_mpa * g.value;
  AddDeterminantCurvature(f, w.slope_mpa * g.slope * i1 + pressure_mpa, out);
  return out;
}

}  // namespace

double ShapeEnergyMpa(const HyperelasticLaw& law, double shear_modulus_mpa,
                      const Eigen::Matrix3d& f) {
  const double isotropic_mpa = IsotropicEnergyMpa(law, shear_modulus_mpa, f);
  return law.fibres.k1_mpa > 0.0 ? isotropic_mpa + FibreEnergyMpa(law.fibres, f) : isotropic_mpa;
}

Eigen::Matrix3d ShapeStressMpa(const HyperelasticLaw& law, double shear_modulus_mpa,
                               const Eigen::Matrix3d& f) {
  Eigen::Matrix3d stress = IsotropicStressMpa(law, shear_modulus_mpa, f);
  if (law.fibres.k1_mpa > 0.0) stress += FibreStressMpa(law.fibres, f);
  return stress;
}

Matrix9 ShapeTangentMpa(const HyperelasticLaw& law, double shear_modulus_mpa,
                        const Eigen::Matrix3d& f, double pressure_mpa) {
  Matrix9 out = IsotropicTangentMpa(law, shear_modulus_mpa, f, pressure_mpa);
  if (law.fibres.k1_mpa > 0.0) out += FibreTangentMpa(law.fibres, f);
  return out;
}

Matrix9 PositivePart(const Matrix9& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Matrix9> eigen(symmetric);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace acus::mechanics
