// Commands and hand movements of the user at the window.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>

namespace acus::window {

/// The caller carries out those up to kQuit. The window carries out the others itself; the caller
/// receives them too, for the record.
enum class Command {
  kFreeze,
  kGainUp,
  kGainDown,
  kAutoGain,
  kDeeper,
  kShallower,
  kSwapHands,
  kHoldBreath,
  kMarkTarget,
  kPressPlunger,  ///< More force of the thumb on the syringe.
  kEasePlunger,
  kUndo,        ///< The newest movement of the tool that mouse and keys move is taken back.
  kSteerOther,  ///< Mouse and arrow keys move the other tool: needle or probe.
  kQuit,        ///< By a key pressed twice, or by closing the window.
  kNextView,    ///< Grid, then each view alone.
  kGrid,
  kStereo,  ///< Off, side by side, red-cyan, shutter glasses.
  kOverlayMore,
  kOverlayLess,
  kNeedleGuide,
  kCameraPreset,
  kVolume,
  kVolumeLook,
  kVolumeDenser,
  kVolumeFainter,
  kVolumeCut,
  kCutOn,
  kCutBack,
  kFigures,
  kHelp,
};

/// The name in recordings: "freeze", "gain_up".
std::string_view NameOf(Command command) noexcept;

struct KeyHelp {
  Command command;
  std::string_view keys;  ///< As printed: "G / Shift+G".
  const char* text;       ///< In English, for the catalogues of translations.
};
/// All keys, in the order of the help page.
std::span<const KeyHelp> Keys() noexcept;

/// Motion of the virtual hand by mouse and keyboard since the last call. Device frame: x to the
/// right, y up, z towards the user.
struct HandInput {
  Eigen::Vector3d moved_mm = Eigen::Vector3d::Zero();    ///< Left button: x and y.
  Eigen::Vector3d turned_rad = Eigen::Vector3d::Zero();  ///< Right button: about x and y.
  double advanced_mm = 0.0;  ///< Wheel: along the needle, forwards positive.
  /// Each of -1, 0, 1 while keys are held: arrows (x, y), Page Down and Page Up (advance).
  Eigen::Vector2d held = Eigen::Vector2d::Zero();
  double held_advance = 0.0;
  bool fine = false;   ///< Shift is held: a tenth of the speed.
  bool pedal = false;  ///< The space bar is held.
};

}  // namespace acus::window
