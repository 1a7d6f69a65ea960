// Stereo modes of the view in three dimensions.
#pragma once

namespace acus::window {

/// kShutter: alternating eyes, for shutter glasses, from the graphics driver's buffers for both
/// eyes (quad-buffered stereo).
enum class Stereo { kOff, kSideBySide, kRedCyan, kShutter };
inline constexpr int kNumStereo = 4;

enum class EyeSide { kLeft, kRight };

/// Each eye sees the whole window.
constexpr bool FillsWindow(Stereo stereo) {
  return stereo == Stereo::kRedCyan || stereo == Stereo::kShutter;
}

}  // namespace acus::window
