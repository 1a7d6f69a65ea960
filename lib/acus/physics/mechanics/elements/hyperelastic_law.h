// How tissue resists large strain: nearly incompressible laws that stiffen.
#pragma once

#include <Eigen/Core>
#include <string_view>

namespace acus::mechanics {

/// Energy per volume of the change of shape, with x = I1bar - 3 and I1bar = J^(-2/3) tr(F^T F):
///   neo_hookean  mu/2 x                          (Treloar 1943)
///   yeoh         mu/2 x + c2 x^2 + c3 x^3        (Yeoh 1993, Rubber Chem. Technol. 66(5):754-771)
///   fung         mu/(2b) (exp(b x) - 1)          (Demiray 1972, J. Biomech. 5(3):309-311)
/// All have the shear modulus mu at small strains, that of the linear model. The change of volume
/// costs U(J) = K/2 (J - 1)^2 beside it (see finite_strain_patch.h).
enum class LawKind { kNeoHookean, kYeoh, kFung };

/// Parameters beside the moduli of small strains; without any, neo_hookean.
struct HyperelasticLaw {
  LawKind kind = LawKind::kNeoHookean;
  double c2_mpa = 0.0;      ///< yeoh.
  double c3_mpa = 0.0;      ///< yeoh; >= 0.
  double exponent_b = 0.0;  ///< fung; > 0.
  bool operator==(const HyperelasticLaw&) const = default;
};

/// "neo_hookean", "yeoh" or "fung".
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

/// Continued beyond the range of use, so that no strain overflows: x < 0, which only inverted
/// tetrahedra have, with the slope at 0; above kLargestX, or where fung's slope is
/// kLargestStiffening times that at 0, as a parabola.
inline constexpr double kLargestX = 50.0;
inline constexpr double kLargestStiffening = 1000.0;
LawAt ValueOf(const HyperelasticLaw& law, double shear_modulus_mpa, double x);

/// J^(-2/3) and its derivatives; below J = kLeastJ, and so where a tetrahedron is inside out, the
/// parabola that joins with two derivatives.
inline constexpr double kLeastJ = 0.1;
struct VolumeFactor {
  double value = 1.0;
  double slope = 0.0;
  double curvature = 0.0;
};
VolumeFactor VolumeFactorAt(double j);

using Matrix9 = Eigen::Matrix<double, 9, 9>;  ///< By entries of F, column by column.

/// Cofactors of F: the derivative of det F. Its columns are cross products of those of F.
Eigen::Matrix3d Cofactor(const Eigen::Matrix3d& gradient);

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
