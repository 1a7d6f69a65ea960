#include "acus/base/math/distributions.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace acus::math {
namespace {

TEST(ChiSquareUpperTail, AgreesWithClosedForms) {
  for (const double x : {0.0, 0.1, 1.0, 2.5, 7.0, 40.0, 300.0}) {
    // Two degrees of freedom: exp(-x/2). Six: with the polynomial of a gamma of integer order.
    EXPECT_NEAR(ChiSquareUpperTail(x, 2), std::exp(-x / 2), 1e-14);
    const double half = x / 2;
    EXPECT_NEAR(ChiSquareUpperTail(x, 6), std::exp(-half) * (1 + half + half * half / 2), 1e-13);
    EXPECT_NEAR(ChiSquareUpperTail(x, 1), std::erfc(std::sqrt(half)), 1e-13);
  }
  EXPECT_EQ(ChiSquareUpperTail(std::numeric_limits<double>::infinity(), 3), 0.0);
}

TEST(FUpperTail, AgreesWithClosedForms) {
  for (const double x : {0.0, 0.01, 0.5, 1.0, 3.0, 20.0, 1e4}) {
    // F(2, n): (1 + 2 x / n)^(-n/2).
    for (const double n : {1.0, 3.0, 9.0, 60.0}) {
      EXPECT_NEAR(FUpperTail(x, 2, n), std::pow(1 + 2 * x / n, -n / 2), 1e-12) << x << " " << n;
    }
    // F(1, 1) is the square of a Cauchy variable.
    EXPECT_NEAR(FUpperTail(x, 1, 1), 1 - 2 / M_PI * std::atan(std::sqrt(x)), 1e-12);
  }
  EXPECT_EQ(FUpperTail(std::numeric_limits<double>::infinity(), 3, 9), 0.0);
}

TEST(FUpperTail, SwapsWithItsReciprocal) {
  for (const double x : {0.2, 1.0, 4.0}) {
    EXPECT_NEAR(FUpperTail(x, 3, 9) + FUpperTail(1 / x, 9, 3), 1.0, 1e-12);
  }
}

}  // namespace
}  // namespace acus::math
