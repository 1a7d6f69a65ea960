#include "acus/base/math/covariance.h"

#include <Eigen/Eigenvalues>

namespace acus::math {

Eigen::Vector3d PrincipalDeviations(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return solver.eigenvalues().cwiseMax(0.0).cwiseSqrt().reverse();
}

}  // namespace acus::math
