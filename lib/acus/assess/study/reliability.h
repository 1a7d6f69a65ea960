// Reliability of measurements: intraclass correlations and Cronbach's alpha.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace acus::study {

/// The six forms of Shrout & Fleiss (1979): rows are persons, columns raters (or trials). The first
/// number is the model, the second whether one rating or the mean of all columns is used.
struct IntraclassCorrelation {
  double icc_1_1 = 0.0, icc_2_1 = 0.0, icc_3_1 = 0.0;
  double icc_1_k = 0.0, icc_2_k = 0.0, icc_3_k = 0.0;
};

/// From the mean squares of the analysis of variance. None if all values are equal. A form with a
/// denominator of 0 (persons do not differ, raters do) is 0.
/// @pre at least two rows and two columns, finite.
std::optional<IntraclassCorrelation> ComputeIcc(const Eigen::MatrixXd& ratings);

/// Cronbach's alpha (1951): rows are persons, columns items. None if the sums do not vary.
/// @pre at least two rows and two columns, finite.
std::optional<double> CronbachAlpha(const Eigen::MatrixXd& answers);

}  // namespace acus::study
