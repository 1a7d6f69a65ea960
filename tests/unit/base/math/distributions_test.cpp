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

TEST(ChiSquareUpperTail, IsOneWhereTheGammaFunctionOverflows) {
  EXPECT_EQ(ChiSquareUpperTail(0.0, 5000.0), 1.0);
  EXPECT_EQ(ChiSquareUpperTail(1e-300, 3600.0), 1.0);
}

// Points of the tables of Abramowitz & Stegun 1972: 26.8 (chi-square) and 26.9 (F).
TEST(UpperTails, AreThoseOfTheTables) {
  EXPECT_NEAR(ChiSquareUpperTail(3.84146, 1), 0.05, 1e-6);
  EXPECT_NEAR(ChiSquareUpperTail(18.3070, 10), 0.05, 1e-6);
  EXPECT_NEAR(ChiSquareUpperTail(50.8922, 30), 0.01, 1e-6);
  EXPECT_NEAR(FUpperTail(4.96, 1, 10), 0.05, 1e-4);
  EXPECT_NEAR(FUpperTail(3.86, 3, 9), 0.05, 1e-4);
  EXPECT_NEAR(FUpperTail(6.99, 3, 9), 0.01, 1e-4);
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

// A probability of 0 or 1 has no finite quantile: the program stops where it was asked for one.
TEST(QuantilesDeathTest, StopOutsideTheirRange) {
  for (const double probability : {-0.1, 0.0, 1.0, 1.1}) {
    EXPECT_DEATH(NormalQuantile(probability), "IsInside") << probability;
    EXPECT_DEATH(StudentQuantile(probability, 5.0), "IsInside") << probability;
    EXPECT_DEATH(ChiSquareQuantile(probability, 5.0), "IsInside") << probability;
  }
  EXPECT_DEATH(StudentQuantile(0.5, 0.0), "degrees_of_freedom");
  EXPECT_DEATH(ChiSquareUpperTail(-1.0, 2.0), "x >= 0.0");
  EXPECT_DEATH(ChiSquareUpperTail(1.0, 0.0), "degrees_of_freedom > 0.0");
  EXPECT_DEATH(FUpperTail(1.0, 0.0, 2.0), "degrees_1 > 0.0");
}

TEST(FUpperTail, SwapsWithItsReciprocal) {
  for (const double x : {0.2, 1.0, 4.0}) {
    EXPECT_NEAR(FUpperTail(x, 3, 9) + FUpperTail(1 / x, 9, 3), 1.0, 1e-12);
  }
}

TEST(FUpperTail, IsExactNearZero) {
  // 1 - z^a / (a B(a, b)) (1 + a (1 - b) / (a + 1) z), z = a x / (b + a x), to the second term.
  const double a = 0.25;
  const double b = 2500.0;
  const double x = 1e-9;
  const double z = a * x / (b + a * x);
  const double beta = std::exp(std::lgamma(a) + std::lgamma(b) - std::lgamma(a + b));
  const double lower = std::pow(z, a) / (a * beta) * (1.0 + a * (1.0 - b) / (a + 1.0) * z);
  EXPECT_NEAR(FUpperTail(x, 2 * a, 2 * b), 1.0 - lower, 1e-13);
}

// Two-sided 95 % points as in any table of Student's distribution.
TEST(StudentQuantile, IsThatOfTheTables) {
  // One degree of freedom is Cauchy's distribution: tan(0.475 pi).
  EXPECT_NEAR(StudentQuantile(0.975, 1), std::tan(0.475 * std::acos(-1.0)), 1e-6);
  // Two: t = a / sqrt(2 (1/4 - a^2/4)) with a = 0.95 in closed form.
  EXPECT_NEAR(StudentQuantile(0.975, 2), 0.95 * std::sqrt(2.0 / (1.0 - 0.95 * 0.95)), 1e-6);
  EXPECT_NEAR(StudentQuantile(0.975, 3), 3.182, 5e-4);
  EXPECT_NEAR(StudentQuantile(0.975, 4), 2.776, 5e-4);
  EXPECT_NEAR(StudentQuantile(0.975, 9), 2.262, 5e-4);
  EXPECT_NEAR(StudentQuantile(0.975, 1000), 1.962, 5e-4);
  EXPECT_NEAR(StudentQuantile(0.95, 2), 2.920, 5e-4);
  EXPECT_NEAR(StudentQuantile(0.95, 9), 1.833, 5e-4);
}

TEST(NormalQuantile, IsThatOfTheTables) {
  EXPECT_NEAR(NormalQuantile(0.5), 0.0, 1e-15);
  EXPECT_NEAR(NormalQuantile(0.95), 1.644854, 5e-7);
  EXPECT_NEAR(NormalQuantile(0.975), 1.959964, 5e-7);
  EXPECT_NEAR(NormalQuantile(0.025), -1.959964, 5e-7);
}

TEST(ChiSquareQuantile, IsThatOfTheTablesAndTurnsTheTailAround) {
  EXPECT_NEAR(ChiSquareQuantile(0.95, 1), 3.84146, 5e-6);
  EXPECT_NEAR(ChiSquareQuantile(0.05, 10), 3.94030, 5e-6);
  for (const double degrees : {0.5, 3.0, 40.0, 5000.0}) {
    for (const double p : {0.001, 0.3, 0.9, 0.999}) {
      EXPECT_NEAR(ChiSquareUpperTail(ChiSquareQuantile(p, degrees), degrees), 1.0 - p, 1e-12);
    }
  }
}

}  // namespace
}  // namespace acus::math
