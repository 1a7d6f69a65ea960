// What a key at the window orders the session to do.
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

/// How the image is set at present.
struct ImageSetting {
  double gain_db = 0.0;
  double depth_mm = 0.0;
};

/// What the session is set to, with orders that no image shows yet: keys that are pressed faster
/// than images come all count.
class OrderedSettings {
 public:
  /// @param image  Of the newest image.
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

/// Why a key does nothing in this session, for the person who pressed it; empty if it does.
struct SessionAbilities {
  bool breath_can_be_held = false;
  bool has_both_tools = false;
  bool has_probe = false;
  bool has_exercise_target = false;
  bool has_syringe = false;
};
std::string WhyWithoutEffect(Command command, const SessionAbilities& session);

/// The order of a command, as things stand in `snapshot`: a key that switches something on switches
/// it off again. Nothing for those that the window has carried out itself, and for kQuit and
/// kSteerOther, which are no orders to the session.
std::optional<live::CommandQueue::Order> OrderOf(Command command,
                                                 const live::LiveSnapshot& snapshot,
                                                 const ImageSetting& present);

}  // namespace acus::window
