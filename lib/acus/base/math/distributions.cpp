#include "acus/base/math/distributions.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::math {
namespace {

/// Tails at a tiny x divide by a gamma function that may overflow: the quotient, zero, is right.
using TailPolicy = boost::math::policies::policy<
    boost::math::policies::overflow_error<boost::math::policies::ignore_error>>;
using ChiSquare = boost::math::chi_squared_distribution<double, TailPolicy>;
using FisherF = boost::math::fisher_f_distribution<double, TailPolicy>;

bool IsInside(double probability) {
  return probability > 0.0 && probability < 1.0;
}

}  // namespace

double ChiSquareUpperTail(double x, double degrees_of_freedom) {
  ACUS_ASSERT(x >= 0.0 && degrees_of_freedom > 0.0);
  if (!std::isfinite(x)) return 0.0;
  return cdf(complement(ChiSquare(degrees_of_freedom), x));
}

double FUpperTail(double x, double degrees_1, double degrees_2) {
  ACUS_ASSERT(x >= 0.0 && degrees_1 > 0.0 && degrees_2 > 0.0);
  if (!std::isfinite(x)) return 0.0;
  return cdf(complement(FisherF(degrees_1, degrees_2), x));
}

double NormalQuantile(double probability) {
  ACUS_ASSERT(IsInside(probability));
  return quantile(boost::math::normal(), probability);
}

double StudentQuantile(double probability, double degrees_of_freedom) {
  ACUS_ASSERT(IsInside(probability) && degrees_of_freedom >= 1.0);
  return quantile(boost::math::students_t(degrees_of_freedom), probability);
}

double ChiSquareQuantile(double probability, double degrees_of_freedom) {
  ACUS_ASSERT(IsInside(probability) && degrees_of_freedom > 0.0);
  return quantile(boost::math::chi_squared(degrees_of_freedom), probability);
}

}  // namespace acus::math
