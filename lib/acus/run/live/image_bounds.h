// How far the ultrasound image may be changed while a session runs.
#pragma once

namespace acus::live {

inline constexpr double kLargestGainDb = 60.0;  ///< Up and down.
inline constexpr double kLeastDepthMm = 20.0;
inline constexpr double kLargestDepthMm = 300.0;

}  // namespace acus::live
