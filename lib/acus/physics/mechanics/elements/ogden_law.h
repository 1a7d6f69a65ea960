// Ogden's energy by principal stretches: tissue that resists compression otherwise than tension.
#pragma once

#include <Eigen/Core>
#include <array>

#include "acus/physics/mechanics/elements/volume_factor.h"

namespace acus::mechanics {

/// One term: a share of the shear modulus, and the exponent of the stretches. An exponent below 0
/// stiffens under compression, one above 2 under tension.
struct OgdenTerm {
  double share = 0.0;     ///< 0 to 1; the shares of a law sum to 1.
  double exponent = 0.0;  ///< At least kLeastOgdenExponent in size where the share is not 0.
  bool operator==(const OgdenTerm&) const = default;
};
inline constexpr std::size_t kMostOgdenTerms = 2;
using OgdenTerms = std::array<OgdenTerm, kMostOgdenTerms>;

/// The energy is a convex function of the logarithmic strains for every exponent; below this one it
/// would soften more than any tissue does.
inline constexpr double kLeastOgdenExponent = 1.0;

/// Energy per volume of the change of shape (Ogden 1972, Proc. R. Soc. A 326:565-584), with the
/// stretches s_i = J^(-1/3) lambda_i:
///   W = sum over terms of 2 mu share / a^2 (s_1^a + s_2^a + s_3^a - 3)
/// Continued by parabolas in s_i^2 where a term is kLargestStiffening times as stiff as at rest, or
/// s_i^2 is above kLargestX or below its inverse: finite for all entries of F up to 1e15.
double OgdenEnergyMpa(const OgdenTerms& terms, double shear_modulus_mpa,
                      const Eigen::Matrix3d& gradient);

/// dW/dF, MPa. Allocates nothing.
Eigen::Matrix3d OgdenStressMpa(const OgdenTerms& terms, double shear_modulus_mpa,
                               const Eigen::Matrix3d& gradient);

/// Second derivative of W by F, MPa, by entries of F, column by column.
Matrix9 OgdenTangentMpa(const OgdenTerms& terms, double shear_modulus_mpa,
                        const Eigen::Matrix3d& gradient);

}  // namespace acus::mechanics
