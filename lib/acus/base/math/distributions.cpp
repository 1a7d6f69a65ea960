#include "acus/base/math/distributions.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::math {
namespace {

constexpr int kMaxTerms = 10000;
constexpr double kPrecision = 1e-15;

/// Evaluates b0 + a1/(b1 + a2/(b2 + ...)) by the modified Lentz algorithm (Thompson & Barnett
/// 1986). `a` and `b` give the coefficients by index, from 1.
template <typename A, typename B>
double ContinuedFraction(double b0, const A& a, const B& b) {
  constexpr double kTiny = 1e-300;
  const auto away_from_zero = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double value = away_from_zero(b0);
  double c = value;
  double d = 0.0;
  for (int i = 1; i < kMaxTerms; ++i) {
    d = 1.0 / away_from_zero(b(i) + a(i) * d);
    c = away_from_zero(b(i) + a(i) / c);
    value *= c * d;
    if (std::abs(c * d - 1.0) < kPrecision) break;
  }
  return value;
}

/// Upper regularised incomplete gamma function Q(s, x).
/// Abramowitz & Stegun 6.5.29 (series, small x) and 6.5.31 (continued fraction).
double GammaQ(double s, double x) {
  if (x <= 0.0) return 1.0;
  if (!std::isfinite(x)) return 0.0;
  const double scale = std::exp(s * std::log(x) - x - std::lgamma(s));
  if (x < s + 1.0) {
    double term = 1.0 / s;
    double sum = term;
    for (int n = 1; n < kMaxTerms && term > kPrecision * sum; ++n) {
      term *= x / (s + n);
      sum += term;
    }
    return std::clamp(1.0 - scale * sum, 0.0, 1.0);
  }
  const double fraction = ContinuedFraction(
      x + 1.0 - s, [s](int i) { return -i * (i - s); },
      [s, x](int i) { return x + 2.0 * i + 1.0 - s; });
  return std::clamp(scale / fraction, 0.0, 1.0);
}

/// Regularised incomplete beta function I_x(a, b), Abramowitz & Stegun 26.5.8.
double BetaI(double x, double a, double b) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  // The fraction converges fast only on this side of the mean.
  if (x > (a + 1.0) / (a + b + 2.0)) return 1.0 - BetaI(1.0 - x, b, a);
  const double scale = std::exp(std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) +
                                a * std::log(x) + b * std::log1p(-x)) /
                       a;
  const double fraction = ContinuedFraction(
      1.0,
      [=](int i) {
        const double m = i / 2;
        return i % 2 == 0 ? m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
                          : -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
      },
      [](int) { return 1.0; });
  return std::clamp(scale / fraction, 0.0, 1.0);
}

}  // namespace

double ChiSquareUpperTail(double x, double degrees_of_freedom) {
  ACUS_ASSERT(x >= 0.0 && degrees_of_freedom > 0.0);
  return GammaQ(0.5 * degrees_of_freedom, 0.5 * x);
}

double FUpperTail(double x, double degrees_1, double degrees_2) {
  ACUS_ASSERT(x >= 0.0 && degrees_1 > 0.0 && degrees_2 > 0.0);
  if (!std::isfinite(x)) return 0.0;
  return BetaI(degrees_2 / (degrees_2 + degrees_1 * x), 0.5 * degrees_2, 0.5 * degrees_1);
}

}  // namespace acus::math
