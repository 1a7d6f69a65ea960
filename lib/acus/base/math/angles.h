// Degrees are for files and screens; everything else computes in radians.
#pragma once

#include <numbers>

namespace acus::math {

inline constexpr double kRadPerDegree = std::numbers::pi / 180.0;

}  // namespace acus::math
