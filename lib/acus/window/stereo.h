// How the view in three dimensions is shown to two eyes.
#pragma once

namespace acus::window {

/// kShutter: to each eye in turn, for shutter glasses, from buffers that the graphics driver has
/// for both (quad-buffered stereo).
enum class Stereo { kOff, kSideBySide, kRedCyan, kShutter };
inline constexpr int kNumStereo = 4;

enum class EyeSide { kLeft, kRight };

/// Each eye sees the whole window.
constexpr bool FillsWindow(Stereo stereo) {
  return stereo == Stereo::kRedCyan || stereo == Stereo::kShutter;
}

}  // namespace acus::window
