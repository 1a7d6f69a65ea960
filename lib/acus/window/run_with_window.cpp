#include "acus/window/run_with_window.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "acus/base/core/monotonic_time.h"
#include "acus/base/translation/translation.h"
#include "acus/window/frame_maker.h"
#include "acus/window/hand_steering.h"
#include "acus/window/orders.h"
#include "acus/window/patient_on_display.h"
#include "acus/window/undo.h"

namespace acus::window {
namespace {

using translation::Translated;

constexpr std::int64_t kNoticeNs = 4'000'000'000;

/// The loop of the window.
class Loop {
 public:
  Loop(live::LiveSession& session, SessionWindows& window, const ConsoleSettings& settings)
      : session_(session),
        window_(window),
        settings_(settings),
        frames_(session, settings.trial, settings.caption) {
    abilities_ = {.breath_can_be_held = session.breath_can_be_held(),
                  .has_both_tools = session.has_needle() && session.has_probe(),
                  .has_probe = session.scene().probe.has_value(),
                  .has_exercise_target = session.exercise() != nullptr &&
                                         session.exercise()->target_in_ct_mm().has_value(),
                  .has_syringe = session.scene().plan.Needs(effects::ports::kPlungerForce)};
  }

  /// False when the user has ended the session.
  bool Turn() {
    const std::int64_t now_ns = MonotonicNs();
    const double dt_s = last_ns_ == 0 ? 0.0 : 1e-9 * static_cast<double>(now_ns - last_ns_);
    last_ns_ = now_ns;
    session_.images().Refresh();
    const live::LiveImage& image = session_.images().Front();
    const camera::CameraTracker* tracker = session_.video();
    const auto video = tracker == nullptr ? nullptr : tracker->Latest();
    if (image.number > 0) {
      if (now_ns > notice_until_ns_) frames_.SetNotice("");
      const DisplayFrame& frame = frames_.Make(image, video.get(), !steers_needle_);
      tip_to_target_mm_ = frame.tip_to_target_mm;
      window_.Show(frame);
      if (num_shown_++ == 0) first_shown_ns_ = MonotonicNs();
      last_shown_ns_ = MonotonicNs();
    }
    window_.HandleEvents();
    if (!Obey(image, now_ns)) return false;
    Move(dt_s);
    return !window_.closed();
  }

  double FramesPerS() const {
    const double span_s = 1e-9 * static_cast<double>(last_shown_ns_ - first_shown_ns_);
    return span_s > 0.0 ? static_cast<double>(num_shown_ - 1) / span_s : 0.0;
  }

  void TakeScreenshot() {
    if (settings_.screenshot.empty()) return;
    window_.WriteScreenshots(settings_.screenshot);
  }

 private:
  bool Obey(const live::LiveImage& image, std::int64_t now_ns) {
    ImageSetting shown;
    const auto& probe = session_.scene().probe;  // Until there is an image.
    if (probe) shown = {probe->gain_db, probe->depth_mm};
    if (image.probe) shown = {image.probe->gain_db, image.probe->depth_mm};
    const double now_s = 1e-9 * static_cast<double>(now_ns);
    ordered_.Refresh(image.snapshot, shown, now_s);
    for (const Command command : window_.TakeCommands()) {
      if (command == Command::kQuit) return false;
      if (command == Command::kSteerOther) steers_needle_ = !steers_needle_;
      if (command == Command::kUndo && !History().TakeBack()) {
        frames_.SetNotice(Translated("There is no movement to take back."));
        notice_until_ns_ = now_ns + kNoticeNs;
      }
      if (std::string why = WhyWithoutEffect(command, abilities_); !why.empty()) {
        frames_.SetNotice(std::move(why));
        notice_until_ns_ = now_ns + kNoticeNs;
        continue;
      }
      const auto order = OrderOf(command, ordered_.snapshot(), ordered_.image());
      if (!order) continue;
      session_.commands().Give(order->kind, order->value);
      ordered_.Add(*order, now_s);
    }
    return true;
  }

  void Move(double dt_s) {
    const HandInput input = window_.TakeHandInput();
    if (input.pedal) session_.HoldPedal();
    const live::HeldTool held = session_.HeldBy(steers_needle_);
    if (held.hand == nullptr) return;
    MovementHistory& history = History();
    const bool moves = !WayOf(input, held.hand->goal() * held.handle_from_tool, dt_s).IsZero();
    history.Note(held.hand->goal(), moves, 1e-9 * static_cast<double>(last_ns_));
    if (const ToolWay back = history.WayBack(held.hand->goal(), dt_s); !back.IsZero()) {
      return held.hand->Nudge(back.way_mm, back.turn_rad);
    }
    Steer(held.hand.get(), held.handle_from_tool, input, dt_s, held.may_advance,
          steers_needle_ ? SpeedShare(tip_to_target_mm_) : 1.0);
  }

  MovementHistory& History() { return steers_needle_ ? of_needle_ : of_probe_; }

  live::LiveSession& session_;
  SessionWindows& window_;
  const ConsoleSettings& settings_;
  FrameMaker frames_;
  OrderedSettings ordered_;
  SessionAbilities abilities_;
  std::int64_t notice_until_ns_ = 0;
  bool steers_needle_ = true;
  MovementHistory of_needle_;
  MovementHistory of_probe_;
  std::optional<double> tip_to_target_mm_;
  std::int64_t last_ns_ = 0;
  std::int64_t num_shown_ = 0;
  std::int64_t first_shown_ns_ = 0;
  std::int64_t last_shown_ns_ = 0;
};

}  // namespace

WindowRun RunWithWindow(const scenario::Scenario& scenario, live::LiveSession& session,
                        const ConsoleSettings& settings, RunContext& context,
                        LoadingScreen* loading) {
  const PatientOnDisplay patient = PatientOnDisplayOf(scenario, session.scene(), context);
  std::unique_ptr<Screen> screen;
  if (loading != nullptr) {
    loading->Show(translation::Marked("preparing the views"), 1.0);
    screen = loading->Release();
  }
  SessionWindows windows(patient, settings, std::move(screen));
  return RunInWindows(windows, session, settings);
}

WindowRun RunInWindows(SessionWindows& windows, live::LiveSession& session,
                       const ConsoleSettings& settings) {
  session.Start();
  Loop loop(session, windows, settings);
  const auto period_ns = static_cast<std::int64_t>(1e9 / settings.rate_hz);
  std::int64_t due_ns = MonotonicNs();
  while (session.Poll() && loop.Turn()) {
    // After a slow image the next ones keep their interval.
    due_ns = std::max(due_ns + period_ns, MonotonicNs());
    std::this_thread::sleep_for(std::chrono::nanoseconds(due_ns - MonotonicNs()));
  }
  loop.TakeScreenshot();
  session.Stop();
  return {session.complete(), loop.FramesPerS(), windows.volume()};
}

}  // namespace acus::window
