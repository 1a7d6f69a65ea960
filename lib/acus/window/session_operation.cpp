#include "acus/window/session_operation.h"

#include <algorithm>
#include <utility>

#include "acus/base/translation/translation.h"
#include "acus/imaging/ultrasound/display/auto_gain.h"
#include "acus/window/hand_steering.h"

namespace acus::window {
namespace {

constexpr double kNoticeS = 4.0;

/// The gain that the image needs; the present one before there is an image.
double AutoGainDb(const live::LiveImage& image, double gain_db) {
  if (!image.probe || image.images.b_mode.pixels.empty()) return gain_db;
  return gain_db + ultrasound::AutoGainChangeDb(image.images.b_mode, image.probe->dynamic_range_db);
}

}  // namespace

SessionOperation::SessionOperation(live::LiveSession& session)
    : session_(session),
      abilities_{.breath_can_be_held = session.breath_can_be_held(),
                 .has_both_tools = session.has_needle() && session.has_probe(),
                 .has_probe = session.scene().probe.has_value(),
                 .has_exercise_target = session.exercise() != nullptr &&
                                        session.exercise()->target_in_ct_mm().has_value(),
                 .has_syringe = session.scene().plan.Needs(effects::ports::kPlungerForce)} {}

bool SessionOperation::Obey(std::span<const Command> commands, const live::LiveImage& image,
                            double now_s) {
  ImageSetting shown;
  const auto& probe = session_.scene().probe;  // Until there is an image.
  if (probe) shown = {probe->gain_db, probe->depth_mm};
  if (image.probe) shown = {image.probe->gain_db, image.probe->depth_mm};
  ordered_.Refresh(image.snapshot, shown, now_s);
  for (const Command command : commands) {
    if (command == Command::kQuit) return false;
    if (command == Command::kSteerOther) steers_needle_ = !steers_needle_;
    std::string why = WhyWithoutEffect(command, abilities_);
    if (command == Command::kUndo && !History().TakeBack()) {
      why = translation::Translated("There is no movement to take back.");
    }
    if (!why.empty()) {
      notice_ = std::move(why);
      notice_until_s_ = now_s + kNoticeS;
      continue;
    }
    ImageSetting present = ordered_.image();
    if (command == Command::kAutoGain) present.auto_gain_db = AutoGainDb(image, shown.gain_db);
    const auto order = OrderOf(command, ordered_.snapshot(), present);
    if (!order) continue;
    session_.commands().Give(order->kind, order->value);
    ordered_.Add(*order, now_s);
  }
  return true;
}

void SessionOperation::Move(const HandInput& input, const std::optional<double>& tip_to_target_mm,
                            double now_s) {
  const double dt_s = moved_s_ ? std::min(now_s - *moved_s_, kLongestHeldS) : 0.0;
  moved_s_ = now_s;
  if (input.pedal) session_.HoldPedal();
  const live::HeldTool held = session_.HeldBy(steers_needle_);
  if (held.hand == nullptr) return;
  MovementHistory& history = History();
  const bool moves = !WayOf(input, held.hand->goal() * held.handle_from_tool, dt_s).IsZero();
  history.Note(held.hand->goal(), moves, now_s);
  if (const ToolWay back = history.WayBack(held.hand->goal(), dt_s); !back.IsZero()) {
    return held.hand->Nudge(back.way_mm, back.turn_rad);
  }
  Steer(held.hand.get(), held.handle_from_tool, input, dt_s, held.may_advance,
        steers_needle_ ? SpeedShare(tip_to_target_mm) : 1.0);
}

std::string SessionOperation::NoticeAt(double now_s) const {
  return now_s < notice_until_s_ ? notice_ : std::string();
}

}  // namespace acus::window
