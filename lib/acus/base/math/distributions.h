// Tail probabilities and quantiles of the distributions that intervals and tests of significance
// need.
#pragma once

namespace acus::math {

/// P(X > x) of a chi-square variable. @pre x >= 0, degrees_of_freedom > 0.
double ChiSquareUpperTail(double x, double degrees_of_freedom);

/// P(X > x) of an F variable (numerator, denominator degrees of freedom). @pre x >= 0, both > 0.
double FUpperTail(double x, double degrees_1, double degrees_2);

/// The x that a standard normal variable stays below with this probability.
/// @pre 0 < probability < 1.
double NormalQuantile(double probability);

/// The same of Student's t. @pre 0 < probability < 1, degrees_of_freedom >= 1.
double StudentQuantile(double probability, double degrees_of_freedom);

/// The same of a chi-square variable. @pre 0 < probability < 1, degrees_of_freedom > 0.
double ChiSquareQuantile(double probability, double degrees_of_freedom);

}  // namespace acus::math
