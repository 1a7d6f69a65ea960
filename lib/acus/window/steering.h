// Converts keys and mouse motion to commands and hand movements.
#pragma once

#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "acus/window/command.h"
#include "acus/window/layout.h"
#include "acus/window/screen.h"
#include "acus/window/stereo.h"

namespace acus::window {

/// The part of the patient that the volume view removes: the side of a plane towards the eye.
enum class VolumeCut { kNone, kAxial, kCoronal, kSagittal, kFacing };
inline constexpr int kNumVolumeCuts = 5;

struct VolumeChoice {
  bool shown = false;
  int look = 0;          ///< Index of the patient's look.
  double opacity = 1.0;  ///< 0.1 to 1.
  VolumeCut cut = VolumeCut::kNone;
  double cut_mm = 0.0;  ///< Distance from the centre of the patient.
};

/// The user's choice of what the window shows.
struct ViewChoice {
  std::optional<ViewKind> alone;
  Stereo stereo = Stereo::kOff;
  double overlay_share = 0.7;  ///< 0 is the video alone.
  bool needle_guide = true;
  bool help = false;
  bool figures = false;     ///< Delays, rates and forces as numbers.
  bool quit_asked = false;  ///< After the first time: a second one ends the session.
  bool steers_probe = false;
  VolumeChoice volume;
};

/// Motion of the eye of the teaching view since the last call.
struct EyeMotion {
  int preset = 0;  ///< 0: none.
  double turn_right_px = 0.0;
  double turn_down_px = 0.0;
  double shift_right_px = 0.0;
  double shift_down_px = 0.0;
  double zoom = 1.0;
};

class Steering {
 public:
  explicit Steering(bool shows_volume = false) { choice_.volume.shown = shows_volume; }

  void Handle(std::span<const InputEvent> events, const Layout& layout,
              std::span<const ViewKind> shown);

  /// Releases keys whose release was not reported: a pedal must not stay down after the focus is
  /// lost.
  void ReleaseKeys() { held_keys_.clear(); }

  bool HoldsKeys() const { return !held_keys_.empty(); }

  const ViewChoice& choice() const { return choice_; }
  bool closed() const { return closed_; }
  std::vector<Command> TakeCommands();
  HandInput TakeHandInput();
  EyeMotion TakeEyeMotion();

 private:
  void KeyDown(const InputEvent& event, std::span<const ViewKind> shown);
  void Letter(char letter, bool shift, std::span<const ViewKind> shown);
  void Move(const InputEvent& event);
  void Wheel(double forward, const InputEvent& event, const Layout& layout);
  void NextView(std::span<const ViewKind> shown);
  void Quit();
  bool VolumeLetter(char letter, bool shift);
  bool PressesTool(const InputEvent& event);
  void ChangeOverlay(double by, Command command);
  bool Holds(const char* key) const { return held_keys_.contains(key); }

  ViewChoice choice_;
  std::vector<Command> commands_;
  HandInput hand_;
  EyeMotion eye_;
  std::set<std::string> held_keys_;
  int drag_button_ = 0;
  bool drags_eye_ = false;
  int last_column_ = 0;
  int last_row_ = 0;
  bool shift_ = false;
  bool closed_ = false;
};

}  // namespace acus::window
