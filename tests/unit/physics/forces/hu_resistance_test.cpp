#include "acus/physics/forces/laws/hu_resistance.h"

#include <gmock/gmock.h>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::forces {
namespace {

const std::vector<double> kHu = {-1000, -200, -100, 0, 40, 300};

TEST(CubicBSpline, BasisIsAPartitionOfUnity) {
  const CubicBSpline spline(kHu, {0, 0, 0, 0, 0, 0, 0, 0}, "test");
  for (double hu = -1200.0; hu <= 400.0; hu += 1.7) {
    double basis[4];
    const int first = spline.Basis(hu, basis);
    EXPECT_GE(first, 0);
    EXPECT_LE(first + 4, spline.num_coefficients());
    double sum = 0.0;
    for (const double b : basis) {
      EXPECT_GE(b, -1e-15);
      sum += b;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
}

// With the knots' means (Greville) as coefficients a B-spline is the straight line y = x.
TEST(CubicBSpline, ReproducesALine) {
  std::vector<double> knots(3, kHu.front());
  knots.insert(knots.end(), kHu.begin(), kHu.end());
  knots.insert(knots.end(), 3, kHu.back());
  std::vector<double> means;
  for (std::size_t i = 0; i + 4 < knots.size(); ++i) {
    means.push_back((knots[i + 1] + knots[i + 2] + knots[i + 3]) / 3.0);
  }
  const CubicBSpline line(kHu, means, "test");
  for (double hu = -1000.0; hu <= 300.0; hu += 13.0) EXPECT_NEAR(line(hu), hu, 1e-9);
  EXPECT_EQ(line(-5000.0), -1000.0);  // Constant beyond the ends.
  EXPECT_NEAR(line(9000.0), 300.0, 1e-9);
}

TEST(CubicBSpline, StaysBetweenItsCoefficientsAndIsSmooth) {
  const CubicBSpline spline(kHu, {0, 0.1, 0.0, 0.5, 0.2, 0.9, 1.0, 1.0}, "test");
  double before = spline(-1000.0);
  for (double hu = -1000.0; hu <= 300.0; hu += 0.1) {
    const double value = spline(hu);
    EXPECT_GE(value, 0.0);
    EXPECT_LE(value, 1.0);
    EXPECT_LT(std::abs(value - before), 0.003);
    before = value;
  }
  EXPECT_NEAR((spline * 2.0)(17.0), 2.0 * spline(17.0), 1e-15);
}

TEST(CubicBSpline, RefusesWhatIsNotASpline) {
  EXPECT_THROW(CubicBSpline({0.0}, {1, 1, 1}, "t"), InputError);
  EXPECT_THROW(CubicBSpline({0.0, 0.0}, {1, 1, 1, 1}, "t"), InputError);
  EXPECT_THROW(CubicBSpline({0.0, 1.0}, {1, 1, 1}, "t"), InputError);
  EXPECT_NO_THROW(CubicBSpline({0.0, 1.0}, {1, 1, 1, 1}, "t"));
}

}  // namespace
}  // namespace acus::forces
