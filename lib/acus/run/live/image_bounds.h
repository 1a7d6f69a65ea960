// Bounds of the settings of the ultrasound image that a session may change.
#pragma once

namespace acus::live {

inline constexpr double kLargestGainDb = 60.0;  ///< Largest change of gain, up and down.
inline constexpr double kLeastDepthMm = 20.0;
inline constexpr double kLargestDepthMm = 300.0;

}  // namespace acus::live
