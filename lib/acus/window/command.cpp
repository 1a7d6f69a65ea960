#include "acus/window/command.h"

#include <array>

#include "acus/base/translation/translation.h"

namespace acus::window {
namespace {

using translation::Marked;

constexpr std::array kKeys = {
    KeyHelp{Command::kFreeze, "F", Marked("freeze and unfreeze the ultrasound image")},
    KeyHelp{Command::kGainUp, "G", Marked("more gain")},
    KeyHelp{Command::kGainDown, "Shift+G", Marked("less gain")},
    KeyHelp{Command::kAutoGain, "R", Marked("automatic gain: tissue at a medium grey")},
    KeyHelp{Command::kDeeper, "D", Marked("deeper")},
    KeyHelp{Command::kShallower, "Shift+D", Marked("shallower")},
    KeyHelp{Command::kMarkTarget, "T", Marked("mark the needle's tip as target")},
    KeyHelp{Command::kPressPlunger, "I", Marked("press the plunger of the syringe harder")},
    KeyHelp{Command::kEasePlunger, "Shift+I", Marked("ease the plunger; below zero: pull it")},
    KeyHelp{Command::kHoldBreath, "B", Marked("hold the breath, and breathe on")},
    KeyHelp{Command::kSwapHands, "W", Marked("swap needle and probe (left-handed)")},
    KeyHelp{Command::kNextView, "V", Marked("next view alone, then all again")},
    KeyHelp{Command::kGrid, "A", Marked("all views")},
    KeyHelp{Command::kOverlayMore, "O", Marked("more of the CT over the video")},
    KeyHelp{Command::kOverlayLess, "Shift+O", Marked("less of the CT over the video")},
    KeyHelp{Command::kNeedleGuide, "N", Marked("line ahead of the needle in the ultrasound")},
    KeyHelp{Command::kCameraPreset, "1 to 7",
            Marked("3D from in front, behind, left, right, top, "
                   "bottom, oblique")},
    KeyHelp{Command::kVolume, "M", Marked("volume view: on, off")},
    KeyHelp{Command::kVolumeLook, "L",
            Marked("volume: next look (bone, skin, soft tissue, vessels)")},
    KeyHelp{Command::kVolumeDenser, "P", Marked("volume: more opaque")},
    KeyHelp{Command::kVolumeFainter, "Shift+P", Marked("volume: less opaque")},
    KeyHelp{Command::kVolumeCut, "C",
            Marked("volume: next cut (axial, coronal, sagittal, facing you)")},
    KeyHelp{Command::kCutOn, "X", Marked("volume: move the cut")},
    KeyHelp{Command::kCutBack, "Shift+X", Marked("volume: move the cut back")},
    KeyHelp{Command::kStereo, "S", Marked("3D in stereo: side by side, red-cyan, shutter, off")},
    KeyHelp{Command::kUndo, "U", Marked("take back the last movement by mouse or keys")},
    KeyHelp{Command::kSteerOther, "Tab", Marked("mouse and arrows move the other tool")},
    KeyHelp{Command::kFigures, "E", Marked("figures for engineers: delays, rates, forces")},
    KeyHelp{Command::kHelp, "H", Marked("this page")},
    KeyHelp{Command::kQuit, "Q", Marked("end the session (press twice)")},
};

}  // namespace

std::string_view NameOf(Command command) noexcept {
  switch (command) {
    case Command::kFreeze:
      return "freeze";
    case Command::kGainUp:
      return "gain_up";
    case Command::kGainDown:
      return "gain_down";
    case Command::kAutoGain:
      return "auto_gain";
    case Command::kDeeper:
      return "deeper";
    case Command::kShallower:
      return "shallower";
    case Command::kSwapHands:
      return "swap_hands";
    case Command::kHoldBreath:
      return "hold_breath";
    case Command::kMarkTarget:
      return "mark_target";
    case Command::kPressPlunger:
      return "press_plunger";
    case Command::kEasePlunger:
      return "ease_plunger";
    case Command::kUndo:
      return "undo";
    case Command::kSteerOther:
      return "steer_other";
    case Command::kQuit:
      return "quit";
    case Command::kNextView:
      return "next_view";
    case Command::kGrid:
      return "grid";
    case Command::kStereo:
      return "stereo";
    case Command::kOverlayMore:
      return "overlay_more";
    case Command::kOverlayLess:
      return "overlay_less";
    case Command::kNeedleGuide:
      return "needle_guide";
    case Command::kCameraPreset:
      return "camera_preset";
    case Command::kVolume:
      return "volume";
    case Command::kVolumeLook:
      return "volume_look";
    case Command::kVolumeDenser:
      return "volume_denser";
    case Command::kVolumeFainter:
      return "volume_fainter";
    case Command::kVolumeCut:
      return "volume_cut";
    case Command::kCutOn:
      return "cut_on";
    case Command::kCutBack:
      return "cut_back";
    case Command::kFigures:
      return "figures";
    case Command::kHelp:
      return "help";
  }
  return "";
}

std::span<const KeyHelp> Keys() noexcept {
  return kKeys;
}

}  // namespace acus::window
