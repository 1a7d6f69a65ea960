#include "acus/physics/mechanics/elements/ogden_law.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace acus::mechanics {
namespace {

/// A function of one squared stretch, and its first two derivatives by it, MPa.
struct StretchEnergy {
  double value = 0.0;
  double slope = 0.0;
  double curvature = 0.0;

  void Add(const StretchEnergy& other) {
    value += other.value;
    slope += other.slope;
    curvature += other.curvature;
  }
};

/// @param stiffness_mpa  2 mu share / a^2.
StretchEnergy TermAt(double stiffness_mpa, double exponent, double square) {
  static const double kLogLargest = std::log(kLargestX);
  static const double kLogStiffening = std::log(kLargestStiffening);
  const double span = std::min(kLogLargest, 2.0 * kLogStiffening / std::abs(exponent));
  const double log_square = std::log(square);  // Of 0, minus infinity.
  const bool is_inside = std::abs(log_square) <= span;
  const double log_at = std::clamp(log_square, -span, span);
  const double at = is_inside ? square : std::exp(log_at);
  const double half = 0.5 * exponent;
  const double power = stiffness_mpa * std::exp(half * log_at);
  const double slope = half * power / at;
  const double curvature = (half - 1.0) * slope / at;
  // A negative curvature (0 < exponent < 2) is continued by the tangent.
  const double bend = is_inside ? curvature : std::max(curvature, 0.0);
  const double over = square - at;
  return {power - stiffness_mpa + over * (slope + 0.5 * bend * over), slope + bend * over, bend};
}

StretchEnergy EnergyAt(const OgdenTerms& terms, double shear_modulus_mpa, double square) {
  StretchEnergy sum;
  for (const OgdenTerm& term : terms) {
    if (term.share == 0.0) continue;
    const double stiffness_mpa =
        2.0 * shear_modulus_mpa * term.share / (term.exponent * term.exponent);
    sum.Add(TermAt(stiffness_mpa, term.exponent, square));
  }
  return sum;
}

/// F in principal axes.
struct Principal {
  explicit Principal(const Eigen::Matrix3d& f)
      : cofactor(Cofactor(f)), volume(VolumeFactorAt(f.col(0).dot(cofactor.col(0)))) {
    // By iteration: computeDirect loses half of the digits where stretches differ much.
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(f.transpose() * f);
    axes = eigen.eigenvectors();
    square = eigen.eigenvalues().cwiseMax(0.0);
  }

  Eigen::Matrix3d cofactor;
  VolumeFactor volume;     ///< J^(-2/3).
  Eigen::Matrix3d axes;    ///< Columns: those of F^T F.
  Eigen::Vector3d square;  ///< lambda_i^2, without the volume's factor.
};

}  // namespace

double OgdenEnergyMpa(const OgdenTerms& terms, double shear_modulus_mpa, const Eigen::Matrix3d& f) {
  const Principal at(f);
  double sum_mpa = 0.0;
  for (int i = 0; i < 3; ++i) {
    sum_mpa += EnergyAt(terms, shear_modulus_mpa, at.volume.value * at.square[i]).value;
  }
  return sum_mpa;
}

Eigen::Matrix3d OgdenStressMpa(const OgdenTerms& terms, double shear_modulus_mpa,
                               const Eigen::Matrix3d& f) {
  const Principal at(f);
  Eigen::Vector3d slope;
  for (int i = 0; i < 3; ++i) {
    slope[i] = EnergyAt(terms, shear_modulus_mpa, at.volume.value * at.square[i]).slope;
  }
  return (2.0 * at.volume.value) * f * (at.axes * slope.asDiagonal() * at.axes.transpose()) +
         (at.volume.slope * slope.dot(at.square)) * at.cofactor;
}

Matrix9 OgdenTangentMpa(const OgdenTerms& terms, double shear_modulus_mpa,
                        const Eigen::Matrix3d& f) {
  const Principal at(f);
  const double g = at.volume.value;
  Eigen::Vector3d slope;
  Eigen::Vector3d curvature;
  for (int i = 0; i < 3; ++i) {
    const StretchEnergy energy = EnergyAt(terms, shear_modulus_mpa, g * at.square[i]);
    slope[i] = energy.slope;
    curvature[i] = energy.curvature;
  }
  // Divided differences of the slope: how the function of a symmetric matrix changes.
  Eigen::Matrix3d difference;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double apart = g * (at.square[i] - at.square[j]);
      const double size = g * std::max(at.square[i], at.square[j]);
      difference(i, j) = std::abs(apart) > 1e-6 * size ? (slope[i] - slope[j]) / apart
                                                       : 0.5 * (curvature[i] + curvature[j]);
    }
  }
  const Eigen::Matrix3d by_axes = at.axes * slope.asDiagonal() * at.axes.transpose();
  const double h = slope.dot(at.square);
  Matrix9 out;
  for (int entry = 0; entry < 9; ++entry) {
    Eigen::Matrix3d df = Eigen::Matrix3d::Zero();
    df(entry) = 1.0;
    const double dj = at.cofactor(entry);
    const double dg = at.volume.slope * dj;
    // Change of F^T F and of its product with the volume's factor, in principal axes.
    const Eigen::Matrix3d half = at.axes.transpose() * (df.transpose() * f) * at.axes;
    const Eigen::Matrix3d dc = half + half.transpose();
    Eigen::Matrix3d dscaled = g * dc;
    dscaled.diagonal() += dg * at.square;
    const Eigen::Matrix3d dslope = at.axes * difference.cwiseProduct(dscaled) * at.axes.transpose();
    double dh = 0.0;
    for (int i = 0; i < 3; ++i) {
      dh += curvature[i] * at.square[i] * dscaled(i, i) + slope[i] * dc(i, i);
    }
    Eigen::Matrix3d column = 2.0 * g * df * by_axes + 2.0 * dg * f * by_axes + 2.0 * g * f * dslope;
    column += (at.volume.slope * dh + at.volume.curvature * h * dj) * at.cofactor;
    out.col(entry) = column.reshaped();
  }
  AddDeterminantCurvature(f, at.volume.slope * h, out);
  return out;
}

}  // namespace acus::mechanics
