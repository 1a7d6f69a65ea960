#include "acus/window/orders.h"

#include <algorithm>

#include "acus/base/translation/translation.h"
#include "acus/run/live/image_bounds.h"

namespace acus::window {

using live::kLargestDepthMm;
using live::kLargestGainDb;
using live::kLeastDepthMm;
using session::CommandKind;
using translation::Translated;

namespace {
/// Images show an order well before this time.
constexpr double kShownAfterS = 0.5;
}  // namespace

void OrderedSettings::Refresh(const live::LiveSnapshot& snapshot, const ImageSetting& image,
                              double now_s) {
  if (now_s - last_order_s_ < kShownAfterS) return;
  snapshot_ = snapshot;
  image_ = image;
}

void OrderedSettings::Add(const live::CommandQueue::Order& order, double now_s) {
  last_order_s_ = now_s;
  switch (order.kind) {
    case CommandKind::kGain:
      image_.gain_db = order.value;
      break;
    case CommandKind::kDepth:
      image_.depth_mm = order.value;
      break;
    case CommandKind::kPlunger:
      snapshot_.plunger_n = order.value;
      break;
    case CommandKind::kFreezeImage:
    case CommandKind::kRunImage:
      snapshot_.frozen = order.kind == CommandKind::kFreezeImage;
      break;
    case CommandKind::kHoldBreath:
    case CommandKind::kBreatheOn:
      snapshot_.breath_held = order.kind == CommandKind::kHoldBreath;
      break;
    default:
      break;
  }
}

std::string WhyWithoutEffect(Command command, const SessionAbilities& session) {
  switch (command) {
    case Command::kHoldBreath:
      return session.breath_can_be_held
                 ? ""
                 : Translated("This patient does not breathe: B has no effect.");
    case Command::kSwapHands:
      return session.has_both_tools ? "" : Translated("There is one tool only: W swaps nothing.");
    case Command::kMarkTarget:
      return session.has_exercise_target
                 ? Translated("The exercise has its target: T marks no other.")
                 : "";
    case Command::kPressPlunger:
    case Command::kEasePlunger:
      return session.has_syringe
                 ? ""
                 : Translated("There is no syringe on this needle: I has no effect.");
    case Command::kGainUp:
    case Command::kGainDown:
    case Command::kAutoGain:
    case Command::kDeeper:
    case Command::kShallower:
    case Command::kFreeze:
      return session.has_probe
                 ? ""
                 : Translated("There is no ultrasound image: this key has no effect.");
    default:
      return "";
  }
}

std::optional<live::CommandQueue::Order> OrderOf(Command command,
                                                 const live::LiveSnapshot& snapshot,
                                                 const ImageSetting& present) {
  const auto order = [](CommandKind kind, double value = 0.0) {
    return live::CommandQueue::Order{kind, value};
  };
  const auto gain = [&](double gain_db) {
    return order(CommandKind::kGain, std::clamp(gain_db, -kLargestGainDb, kLargestGainDb));
  };
  const auto depth = [&](double step_mm) {
    return order(CommandKind::kDepth,
                 std::clamp(present.depth_mm + step_mm, kLeastDepthMm, kLargestDepthMm));
  };
  const auto plunger = [&](double step_n) {
    return order(CommandKind::kPlunger,
                 std::clamp(snapshot.plunger_n + step_n, -kMostThumbN, kMostThumbN));
  };
  switch (command) {
    case Command::kPressPlunger:
      return plunger(kPlungerStepN);
    case Command::kEasePlunger:
      return plunger(-kPlungerStepN);
    case Command::kFreeze:
      return order(snapshot.frozen ? CommandKind::kRunImage : CommandKind::kFreezeImage);
    case Command::kGainUp:
      return gain(present.gain_db + kGainStepDb);
    case Command::kGainDown:
      return gain(present.gain_db - kGainStepDb);
    case Command::kAutoGain:
      return gain(present.auto_gain_db);
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
