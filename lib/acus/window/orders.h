// Converts keys at the window to orders for the session.
#pragma once

#include <optional>
#include <string>

#include "acus/run/live/command_queue.h"
#include "acus/run/live/live_snapshot.h"
#include "acus/window/command.h"

namespace acus::window {

inline constexpr double kGainStepDb = 3.0;
inline constexpr double kDepthStepMm = 10.0;
inline constexpr double kPlungerStepN = 1.0;
/// By keys: a force that a thumb holds for seconds.
inline constexpr double kMostThumbN = 40.0;

/// The current settings of the image.
struct ImageSetting {
  double gain_db = 0.0;
  double depth_mm = 0.0;
  double auto_gain_db = 0.0;  ///< The gain that the newest image needs; for kAutoGain.
};

/// The settings of the session with orders that no image shows yet, so that each of several quick
/// key presses counts.
class OrderedSettings {
 public:
  /// @param image  Settings of the newest image.
  void Refresh(const live::LiveSnapshot& snapshot, const ImageSetting& image, double now_s);
  /// @param order  Given to the session at `now_s`.
  void Add(const live::CommandQueue::Order& order, double now_s);
  const live::LiveSnapshot& snapshot() const { return snapshot_; }
  const ImageSetting& image() const { return image_; }

 private:
  live::LiveSnapshot snapshot_;
  ImageSetting image_;
  double last_order_s_ = -1e9;
};

/// The features of a session. WhyWithoutEffect() gives a message for the user if a key needs a
/// missing one; else it is empty.
struct SessionAbilities {
  bool breath_can_be_held = false;
  bool has_both_tools = false;
  bool has_probe = false;
  bool has_exercise_target = false;
  bool has_syringe = false;
};
std::string WhyWithoutEffect(Command command, const SessionAbilities& session);

/// The order of a command in the state `snapshot`: a key that switches something on switches it off
/// again. Nothing for commands that the window has carried out itself, and for kQuit and
/// kSteerOther, which are no orders to the session.
std::optional<live::CommandQueue::Order> OrderOf(Command command,
                                                 const live::LiveSnapshot& snapshot,
                                                 const ImageSetting& present);

}  // namespace acus::window
