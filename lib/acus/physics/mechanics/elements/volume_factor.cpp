#include "acus/physics/mechanics/elements/volume_factor.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace acus::mechanics {

VolumeFactor VolumeFactorAt(double j) {
  const double at = std::max(j, kLeastJ);
  const double root = std::cbrt(at);
  const double value = 1.0 / (root * root);
  const double slope = -2.0 / 3.0 * value / at;
  const double curvature = -5.0 / 3.0 * slope / at;
  const double over = std::min(j - kLeastJ, 0.0);
  return {value + over * (slope + 0.5 * curvature * over), slope + curvature * over, curvature};
}

Eigen::Matrix3d Cofactor(const Eigen::Matrix3d& f) {
  Eigen::Matrix3d c;
  c.col(0) = f.col(1).cross(f.col(2));
  c.col(1) = f.col(2).cross(f.col(0));
  c.col(2) = f.col(0).cross(f.col(1));
  return c;
}

void AddDeterminantCurvature(const Eigen::Matrix3d& f, double weight, Matrix9& out) {
  // Blocks are cross products with a column of F.
  const auto cross = [&](int column) {
    const Eigen::Vector3d v = weight * f.col(column);
    Eigen::Matrix3d m;
    m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
    return m;
  };
  // det F = f0 . (f1 x f2): d/df1 of f1 x f2 is -[f2]x, of f2 by d/df2 is [f1]x.
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const int c = (a + 2) % 3;
    out.block<3, 3>(3 * a, 3 * b) -= cross(c);
    out.block<3, 3>(3 * a, 3 * c) += cross(b);
  }
}

}  // namespace acus::mechanics
