// From keys and mouse to what the person wants.
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

/// What is taken away of the patient in the volume view: the side of a plane that the eye is on.
enum class VolumeCut { kNone, kAxial, kCoronal, kSagittal, kFacing };
inline constexpr int kNumVolumeCuts = 5;

struct VolumeChoice {
  bool shown = false;
  int look = 0;          ///< Of those that the patient has, in turn.
  double opacity = 1.0;  ///< 0.1 to 1.
  VolumeCut cut = VolumeCut::kNone;
  double cut_mm = 0.0;  ///< From the middle of the patient.
};

/// What the window shows, as far as the person chooses it.
struct ViewChoice {
  std::optional<ViewKind> alone;
  Stereo stereo = Stereo::kOff;
  double overlay_share = 0.7;  ///< 0 is the video alone.
  bool needle_guide = true;
  bool help = false;
  bool quit_asked = false;  ///< Once: a second time ends the session.
  bool steers_probe = false;
  VolumeChoice volume;
};

/// Of the teaching view, since it was last asked for.
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

  /// Of keys whose release was not told: a pedal must not stay down when the window is left.
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
