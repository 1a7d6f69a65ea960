// Robust statistics of small samples. Deterministic; the input order does not matter.
#pragma once

#include <span>

namespace acus::math {

double Mean(std::span<const double> values);  ///< @pre not empty.
double StandardDeviation(
    std::span<const double> values);                    ///< n - 1 in the denominator; @pre n >= 2.
double RootMeanSquare(std::span<const double> values);  ///< @pre not empty.

/// Linear interpolation between order statistics (type 7 of Hyndman & Fan 1996).
/// @pre not empty, fraction in [0, 1].
double Quantile(std::span<const double> values, double fraction);
double Median(std::span<const double> values);  ///< @pre not empty.

/// Median absolute deviation times 1.4826: estimates the standard deviation of a normal sample.
double RobustDeviation(std::span<const double> values);

}  // namespace acus::math
