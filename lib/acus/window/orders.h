// What a key at the window orders the session to do.
#pragma once

#include <optional>

#include "acus/run/live/command_queue.h"
#include "acus/run/live/live_snapshot.h"
#include "acus/window/command.h"

namespace acus::window {

inline constexpr double kGainStepDb = 3.0;
inline constexpr double kDepthStepMm = 10.0;

/// How the picture is set at present.
struct PictureSetting {
  double gain_db = 0.0;
  double depth_mm = 0.0;
};

/// The order of a command, as things stand in `snapshot`: a key that switches something on switches
/// it off again. Nothing for those that the window has carried out itself, and for kQuit and
/// kSteerOther, which are no orders to the session.
std::optional<live::CommandQueue::Order> OrderOf(Command command,
                                                 const live::LiveSnapshot& snapshot,
                                                 const PictureSetting& present);

}  // namespace acus::window
