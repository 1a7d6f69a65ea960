#include "acus/assess/regression/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace acus::regression {
namespace {

/// Two series of calibrations taken in turn: what a neighbour on the machine takes falls out of
/// their least values, what the calibration itself makes of the machine does not.
TEST(Calibration, ItsLeastTimesAgree) {
  std::array<double, 2> least_s;
  least_s.fill(std::numeric_limits<double>::infinity());
  for (int turn = 0; turn < 10; ++turn) {
    double& least = least_s[turn % least_s.size()];
    least = std::min(least, CalibrationSeconds());
  }
  EXPECT_GT(least_s[0], 1e-3);
  EXPECT_LT(std::abs(std::log(least_s[0] / least_s[1])), std::log(1.25));
}

}  // namespace
}  // namespace acus::regression
