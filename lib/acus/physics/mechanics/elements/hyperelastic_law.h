// How tissue resists large strain: nearly incompressible laws that stiffen.
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "acus/physics/mechanics/elements/fibre_law.h"
#include "acus/physics/mechanics/elements/ogden_law.h"
#include "acus/physics/mechanics/elements/volume_factor.h"

namespace acus::mechanics {

/// Energy per volume of the change of shape, with x = I1bar - 3 and I1bar = J^(-2/3) tr(F^T F):
///   neo_hookean  mu/2 x                          (Treloar 1943)
///   yeoh         mu/2 x + c2 x^2 + c3 x^3        (Yeoh 1993, Rubber Chem. Technol. 66(5):754-771)
///   fung         mu/(2b) (exp(b x) - 1)          (Demiray 1972, J. Biomech. 5(3):309-311)
///   knowles      mu/(2b) ((1 + b x/n)^n - 1)     (Knowles 1977, Int. J. Fract. 13(5):611-639)
///   ogden        by principal stretches: see ogden_law.h
/// All have the shear modulus mu at small strains, that of the linear model. Fibres may add theirs.
/// The change of volume costs U(J) = K/2 (J - 1)^2 beside it (see finite_strain_body.h).
enum class LawKind { kNeoHookean, kYeoh, kFung, kKnowles, kOgden };

/// Parameters beside the moduli of small strains; without any, neo_hookean.
struct HyperelasticLaw {
  LawKind kind = LawKind::kNeoHookean;
  double c2_mpa = 0.0;      ///< yeoh.
  double c3_mpa = 0.0;      ///< yeoh; >= 0.
  double exponent_b = 0.0;  ///< fung, knowles; > 0.
  double power_n = 1.0;     ///< knowles; below 1 it softens, at least kLeastPower.
  OgdenTerms ogden{};
  Fibres fibres{};
  bool operator==(const HyperelasticLaw&) const = default;
};

/// Below this power the law of Knowles is not elliptic: shear would gather in a band.
inline constexpr double kLeastPower = 0.5;

/// "neo_hookean", "yeoh", "fung", "knowles" or "ogden".
std::string_view LawName(LawKind kind);

/// Least of (dW/dx) / (mu/2) over x >= 0. A law whose slope falls below 0 would let go under
/// strain: tables refuse less than kLeastSlopeShare.
inline constexpr double kLeastSlopeShare = 0.05;
double LeastSlopeShare(const HyperelasticLaw& law, double shear_modulus_mpa);

/// Energy and its first two derivatives by x, MPa.
struct LawAt {
  double energy_mpa = 0.0;
  double slope_mpa = 0.0;
  double curvature_mpa = 0.0;
};

/// Continued beyond the range of use: x < 0, which only inverted tetrahedra have, with the slope at
/// 0; above kLargestX, or where fung's slope is kLargestStiffening times that at 0, as a parabola.
/// @pre the law is not ogden, which is no function of x.
LawAt ValueOf(const HyperelasticLaw& law, double shear_modulus_mpa, double x);

/// W of the law at F, MPa. Finite for entries of F up to 1e15.
double ShapeEnergyMpa(const HyperelasticLaw& law, double shear_modulus_mpa,
                      const Eigen::Matrix3d& gradient);

/// First Piola-Kirchhoff stress dW/dF, MPa.
Eigen::Matrix3d ShapeStressMpa(const HyperelasticLaw& law, double shear_modulus_mpa,
                               const Eigen::Matrix3d& gradient);

/// Second derivative of W(F) + pressure_mpa * det F by F, MPa.
Matrix9 ShapeTangentMpa(const HyperelasticLaw& law, double shear_modulus_mpa,
                        const Eigen::Matrix3d& gradient, double pressure_mpa);

/// The nearest matrix without negative eigenvalues.
Matrix9 PositivePart(const Matrix9& symmetric);

}  // namespace acus::mechanics
