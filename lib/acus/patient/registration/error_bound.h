// How large an error may become, from its covariance.
#pragma once

#include <Eigen/Core>

namespace acus::registration {

/// The length that a normal error of mean 0 stays below with probability `confidence`: the
/// covariance may be flat (needle-like or disc-like).
/// @pre 0 < confidence < 1, the covariance is symmetric and has no negative eigenvalue.
double LengthBoundMm(const Eigen::Matrix3d& covariance_mm2, double confidence);

/// The same if the covariance was scaled by a variance that was estimated from residuals with
/// `degrees_of_freedom`: the error is then t distributed, and the bound wider. In a registration
/// residuals and error are independent to first order, so that it holds as stated.
double LengthBoundMm(const Eigen::Matrix3d& covariance_mm2, double confidence,
                     double degrees_of_freedom);

/// The factors on an estimated standard deviation between which the true one lies with probability
/// `confidence`: sqrt(k / chi2).
struct DeviationInterval {
  double low = 1.0;
  double high = 1.0;
};
DeviationInterval DeviationIntervalOf(double degrees_of_freedom, double confidence);

}  // namespace acus::registration
