// What all laws of shape need of a deformation gradient: J^(-2/3) and the derivatives of det F.
#pragma once

#include <Eigen/Core>

namespace acus::mechanics {

using Matrix9 = Eigen::Matrix<double, 9, 9>;  ///< By entries of F, column by column.

/// Laws are continued by parabolas where x = I1bar - 3 is above kLargestX, or where they have
/// stiffened by kLargestStiffening, so that no strain overflows.
inline constexpr double kLargestX = 50.0;
inline constexpr double kLargestStiffening = 1000.0;

/// J^(-2/3) and its derivatives; below J = kLeastJ, and so where a tetrahedron is inside out, the
/// parabola that joins with two derivatives.
inline constexpr double kLeastJ = 0.1;
struct VolumeFactor {
  double value = 1.0;
  double slope = 0.0;
  double curvature = 0.0;
};
VolumeFactor VolumeFactorAt(double j);

/// Cofactors of F: the derivative of det F. Its columns are cross products of those of F.
Eigen::Matrix3d Cofactor(const Eigen::Matrix3d& gradient);

/// Adds the second derivative of det F, times `weight`.
void AddDeterminantCurvature(const Eigen::Matrix3d& gradient, double weight, Matrix9& out);

}  // namespace acus::mechanics
