#include "acus/window/orders.h"

#include <algorithm>

#include "acus/run/live/picture_bounds.h"

namespace acus::window {

using live::kLargestDepthMm;
using live::kLargestGainDb;
using live::kLeastDepthMm;
using session::CommandKind;

std::optional<live::CommandQueue::Order> OrderOf(Command command,
                                                 const live::LiveSnapshot& snapshot,
                                                 const PictureSetting& present) {
  const auto order = [](CommandKind kind, double value = 0.0) {
    return live::CommandQueue::Order{kind, value};
  };
  const auto gain = [&](double step_db) {
    return order(CommandKind::kGain,
                 std::clamp(present.gain_db + step_db, -kLargestGainDb, kLargestGainDb));
  };
  const auto depth = [&](double step_mm) {
    return order(CommandKind::kDepth,
                 std::clamp(present.depth_mm + step_mm, kLeastDepthMm, kLargestDepthMm));
  };
  switch (command) {
    case Command::kFreeze:
      return order(snapshot.frozen ? CommandKind::kRunImage : CommandKind::kFreezeImage);
    case Command::kGainUp:
      return gain(kGainStepDb);
    case Command::kGainDown:
      return gain(-kGainStepDb);
    case Command::kDeeper:
      return depth(kDepthStepMm);
    case Command::kShallower:
      return depth(-kDepthStepMm);
    case Command::kSwapHands:
      return order(CommandKind::kSwapHands);
    case Command::kHoldBreath:
      return order(snapshot.breath_held ? CommandKind::kBreatheOn : CommandKind::kHoldBreath);
    case Command::kMarkTarget:
      return order(CommandKind::kMarkTarget);
    default:
      return std::nullopt;
  }
}

}  // namespace acus::window
