// Tail probabilities of the distributions that tests of significance need.
#pragma once

namespace acus::math {

/// P(X > x) of a chi-square variable. @pre x >= 0, degrees_of_freedom > 0.
double ChiSquareUpperTail(double x, double degrees_of_freedom);

/// P(X > x) of an F variable (numerator, denominator degrees of freedom). @pre x >= 0, both > 0.
double FUpperTail(double x, double degrees_1, double degrees_2);

}  // namespace acus::math
