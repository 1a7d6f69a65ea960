// What a covariance says of a scatter in three dimensions.
#pragma once

#include <Eigen/Core>

namespace acus::math {

/// Standard deviations along the principal axes, the largest first; in the unit of the scatter.
Eigen::Vector3d PrincipalDeviations(const Eigen::Matrix3d& covariance);

}  // namespace acus::math
