#include "acus/window/steering.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

namespace acus::window {
namespace {

using Kind = InputEvent::Kind;

constexpr double kMmPerPx = 0.25;
constexpr double kOrbitRadPerPx = 0.005;
constexpr double kMmPerWheelStep = 1.0;
constexpr double kZoomPerWheelStep = 1.1;
constexpr double kFineShare = 0.1;
/// A key moves the tool by this at once, however briefly it is pressed: a slow window sees the
/// press and the release at the same time.
constexpr double kMmPerPress = 0.5;
constexpr double kOverlayStep = 0.1;
constexpr double kOpacityStep = 0.1;
constexpr double kCutStepMm = 5.0;
constexpr double kFarthestCutMm = 1000.0;

bool TurnsTheEye(const Layout::View* view) {
  return view != nullptr && (view->kind == ViewKind::kTeaching || view->kind == ViewKind::kVolume);
}

}  // namespace

void Steering::Handle(std::span<const InputEvent> events, const Layout& layout,
                      std::span<const ViewKind> shown) {
  for (const InputEvent& event : events) {
    if (event.kind != Kind::kClose) shift_ = event.shift;
    switch (event.kind) {
      case Kind::kKeyDown:
        KeyDown(event, shown);
        break;
      case Kind::kKeyUp:
        held_keys_.erase(event.key);
        break;
      case Kind::kButtonDown: {
        const Layout::View* view = layout.At(event.column, event.row);
        drag_button_ = view == nullptr ? 0 : event.button;
        drags_eye_ = TurnsTheEye(view);
        break;
      }
      case Kind::kButtonUp:
        if (event.button == drag_button_) drag_button_ = 0;
        break;
      case Kind::kMove:
        Move(event);
        break;
      case Kind::kWheelForward:
        Wheel(1.0, event, layout);
        break;
      case Kind::kWheelBackward:
        Wheel(-1.0, event, layout);
        break;
      case Kind::kClose:
        closed_ = true;
        commands_.push_back(Command::kQuit);
        break;
    }
    last_column_ = event.column;
    last_row_ = event.row;
  }
}

void Steering::KeyDown(const InputEvent& event, std::span<const ViewKind> shown) {
  const bool repeated = !held_keys_.insert(event.key).second;
  const bool is_letter =
      event.key.size() == 1 && std::isalpha(static_cast<unsigned char>(event.key[0])) != 0;
  if (is_letter) {
    const char letter = static_cast<char>(std::tolower(static_cast<unsigned char>(event.key[0])));
    // Only keys that increase or decrease a value repeat while held.
    const bool may_repeat = letter == 'g' || letter == 'd' || letter == 'o' || letter == 'p' ||
                            letter == 'x' || letter == 'i';
    if (repeated && !may_repeat) return;
    if (letter != 'q') choice_.quit_asked = false;
    Letter(letter, event.shift, shown);
    return;
  }
  if (repeated) return;
  if (event.key == "Shift_L" || event.key == "Shift_R") return;
  if (PressesTool(event)) return;
  choice_.quit_asked = false;
  if (event.key == "Tab" || event.key == "ISO_Left_Tab") {
    choice_.steers_probe = !choice_.steers_probe;
    commands_.push_back(Command::kSteerOther);
  } else if (event.key == "Escape") {
    if (choice_.help) {
      choice_.help = false;
    } else {
      choice_.alone.reset();
      commands_.push_back(Command::kGrid);
    }
  } else if (event.key.size() == 1 && event.key[0] >= '1' && event.key[0] <= '7') {
    eye_.preset = event.key[0] - '0';
    commands_.push_back(Command::kCameraPreset);
  }
}

void Steering::Letter(char letter, bool shift, std::span<const ViewKind> shown) {
  if (VolumeLetter(letter, shift)) return;
  const auto add = [&](Command command) { commands_.push_back(command); };
  switch (letter) {
    case 'f':
      return add(Command::kFreeze);
    case 'g':
      return add(shift ? Command::kGainDown : Command::kGainUp);
    case 'r':
      return add(Command::kAutoGain);
    case 'd':
      return add(shift ? Command::kShallower : Command::kDeeper);
    case 't':
      return add(Command::kMarkTarget);
    case 'i':
      return add(shift ? Command::kEasePlunger : Command::kPressPlunger);
    case 'b':
      return add(Command::kHoldBreath);
    case 'u':
      return add(Command::kUndo);
    case 'w':
      return add(Command::kSwapHands);
    case 'v':
      return NextView(shown);
    case 'a':
      choice_.alone.reset();
      return add(Command::kGrid);
    case 'o':
      return ChangeOverlay(shift ? -kOverlayStep : kOverlayStep,
                           shift ? Command::kOverlayLess : Command::kOverlayMore);
    case 'n':
      choice_.needle_guide = !choice_.needle_guide;
      return add(Command::kNeedleGuide);
    case 's':
      choice_.stereo = static_cast<Stereo>((static_cast<int>(choice_.stereo) + 1) % kNumStereo);
      return add(Command::kStereo);
    case 'e':
      choice_.figures = !choice_.figures;
      return add(Command::kFigures);
    case 'h':
      choice_.help = !choice_.help;
      return add(Command::kHelp);
    case 'q':
      return Quit();
    default:
      return;
  }
}

/// True if the letter is a key of the volume view.
bool Steering::VolumeLetter(char letter, bool shift) {
  VolumeChoice& volume = choice_.volume;
  const double sign = shift ? -1.0 : 1.0;
  switch (letter) {
    case 'm':
      volume.shown = !volume.shown;
      commands_.push_back(Command::kVolume);
      return true;
    case 'l':
      ++volume.look;
      commands_.push_back(Command::kVolumeLook);
      return true;
    case 'p':
      volume.opacity = std::clamp(volume.opacity + sign * kOpacityStep, kOpacityStep, 1.0);
      commands_.push_back(shift ? Command::kVolumeFainter : Command::kVolumeDenser);
      return true;
    case 'c':
      volume.cut = static_cast<VolumeCut>((static_cast<int>(volume.cut) + 1) % kNumVolumeCuts);
      volume.cut_mm = 0.0;
      commands_.push_back(Command::kVolumeCut);
      return true;
    case 'x':
      volume.cut_mm =
          std::clamp(volume.cut_mm + sign * kCutStepMm, -kFarthestCutMm, kFarthestCutMm);
      commands_.push_back(shift ? Command::kCutBack : Command::kCutOn);
      return true;
    default:
      return false;
  }
}

/// True if the key moves the tool.
bool Steering::PressesTool(const InputEvent& event) {
  const double way_mm = kMmPerPress * (event.shift ? kFineShare : 1.0);
  if (event.key == "Right" || event.key == "Left") {
    hand_.moved_mm.x() += event.key == "Right" ? way_mm : -way_mm;
  } else if (event.key == "Up" || event.key == "Down") {
    hand_.moved_mm.y() += event.key == "Up" ? way_mm : -way_mm;
  } else if (event.key == "Next" || event.key == "Prior") {
    hand_.advanced_mm += event.key == "Next" ? way_mm : -way_mm;
  } else {
    return false;
  }
  choice_.quit_asked = false;
  return true;
}

void Steering::ChangeOverlay(double by, Command command) {
  choice_.overlay_share = std::clamp(choice_.overlay_share + by, 0.0, 1.0);
  commands_.push_back(command);
}

void Steering::NextView(std::span<const ViewKind> shown) {
  if (!choice_.alone) {
    if (!shown.empty()) choice_.alone = shown.front();
  } else {
    const auto at = std::ranges::find(shown, *choice_.alone);
    if (at == shown.end() || at + 1 == shown.end()) {
      choice_.alone.reset();
    } else {
      choice_.alone = *(at + 1);
    }
  }
  commands_.push_back(Command::kNextView);
}

void Steering::Quit() {
  // A single accidental key press must not end a session.
  if (choice_.quit_asked) commands_.push_back(Command::kQuit);
  choice_.quit_asked = !choice_.quit_asked;
}

void Steering::Move(const InputEvent& event) {
  if (drag_button_ == 0) return;
  const double right = event.column - last_column_;
  const double down = event.row - last_row_;
  if (drags_eye_) {
    if (drag_button_ == 1) {
      eye_.turn_right_px += right;
      eye_.turn_down_px += down;
    } else if (drag_button_ == 2) {
      eye_.shift_right_px += right;
      eye_.shift_down_px += down;
    } else {
      eye_.zoom *= std::pow(1.01, down);
    }
    return;
  }
  const double share = event.shift ? kFineShare : 1.0;
  if (drag_button_ == 1) {
    hand_.moved_mm += share * kMmPerPx * Eigen::Vector3d(right, -down, 0.0);
  } else if (drag_button_ == 3) {
    // To the right turns the tool's end to the right: about y, which is up.
    hand_.turned_rad += share * kOrbitRadPerPx * Eigen::Vector3d(down, right, 0.0);
  }
}

void Steering::Wheel(double forward, const InputEvent& event, const Layout& layout) {
  const Layout::View* view = layout.At(event.column, event.row);
  if (TurnsTheEye(view)) {
    eye_.zoom *= std::pow(kZoomPerWheelStep, -forward);
  } else if (view != nullptr) {
    hand_.advanced_mm += forward * kMmPerWheelStep * (event.shift ? kFineShare : 1.0);
  }
}

std::vector<Command> Steering::TakeCommands() {
  return std::exchange(commands_, {});
}

HandInput Steering::TakeHandInput() {
  HandInput out = std::exchange(hand_, {});
  const auto way = [&](const char* plus, const char* minus) {
    return (Holds(plus) ? 1.0 : 0.0) - (Holds(minus) ? 1.0 : 0.0);
  };
  out.held = {way("Right", "Left"), way("Up", "Down")};
  out.held_advance = way("Next", "Prior");
  out.fine = shift_;
  out.pedal = Holds("space");
  return out;
}

EyeMotion Steering::TakeEyeMotion() {
  return std::exchange(eye_, {});
}

}  // namespace acus::window
