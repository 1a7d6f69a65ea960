#include "acus/window/command.h"

#include <array>

namespace acus::window {
namespace {

constexpr std::array kKeys = {
    KeyHelp{Command::kFreeze, "F", "freeze and unfreeze the ultrasound image"},
    KeyHelp{Command::kGainUp, "G", "more gain"},
    KeyHelp{Command::kGainDown, "Shift+G", "less gain"},
    KeyHelp{Command::kDeeper, "D", "deeper"},
    KeyHelp{Command::kShallower, "Shift+D", "shallower"},
    KeyHelp{Command::kMarkTarget, "T", "mark the needle's tip as target"},
    KeyHelp{Command::kPressPlunger, "I", "press the plunger of the syringe harder"},
    KeyHelp{Command::kEasePlunger, "Shift+I", "ease the plunger; below zero: pull it"},
    KeyHelp{Command::kHoldBreath, "B", "hold the breath, and breathe on"},
    KeyHelp{Command::kSwapHands, "W", "swap needle and probe (left-handed)"},
    KeyHelp{Command::kNextView, "V", "next view alone, then all again"},
    KeyHelp{Command::kGrid, "A", "all views"},
    KeyHelp{Command::kOverlayMore, "O", "more of the CT over the video"},
    KeyHelp{Command::kOverlayLess, "Shift+O", "less of the CT over the video"},
    KeyHelp{Command::kNeedleGuide, "N", "line ahead of the needle in the ultrasound"},
    KeyHelp{Command::kCameraPreset, "1 to 7",
            "3D from in front, behind, left, right, top, "
            "bottom, oblique"},
    KeyHelp{Command::kVolume, "M", "volume view: on, off"},
    KeyHelp{Command::kVolumeLook, "L", "volume: next look (bone, skin, soft tissue, vessels)"},
    KeyHelp{Command::kVolumeDenser, "P", "volume: more opaque"},
    KeyHelp{Command::kVolumeFainter, "Shift+P", "volume: less opaque"},
    KeyHelp{Command::kVolumeCut, "C", "volume: next cut (axial, coronal, sagittal, facing you)"},
    KeyHelp{Command::kCutOn, "X", "volume: move the cut"},
    KeyHelp{Command::kCutBack, "Shift+X", "volume: move the cut back"},
    KeyHelp{Command::kStereo, "S", "3D in stereo: side by side, red-cyan, shutter, off"},
    KeyHelp{Command::kSteerOther, "Tab", "mouse and arrows move the other tool"},
    KeyHelp{Command::kHelp, "H", "this page"},
    KeyHelp{Command::kQuit, "Q", "end the session (press twice)"},
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
    case Command::kHelp:
      return "help";
  }
  return "";
}

std::span<const KeyHelp> Keys() noexcept {
  return kKeys;
}

}  // namespace acus::window
