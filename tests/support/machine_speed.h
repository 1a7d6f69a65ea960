// Limits on times are stated for a machine of a certain speed; a slower one, or one that shares its
// cores, gets them in proportion.
#pragma once

#include <algorithm>

#include "acus/assess/regression/calibration.h"

namespace acus::testing_support {

/// How many times longer than on the machine of the limits, where the calibration loop of
/// acus-regression takes 15 ms of CPU time, work takes here and now. At least 1.
inline double Slowness() {
  constexpr double kLoopOfTheLimitsS = 0.015;
  return std::max(1.0, regression::CalibrationSeconds() / kLoopOfTheLimitsS);
}

}  // namespace acus::testing_support
