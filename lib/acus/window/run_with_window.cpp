#include "acus/window/run_with_window.h"

#include <algorithm>
#include <chrono>
#include <thread>

#include "acus/base/core/monotonic_time.h"
#include "acus/base/translation/translation.h"
#include "acus/window/frame_maker.h"
#include "acus/window/patient_on_display.h"
#include "acus/window/session_operation.h"

namespace acus::window {
namespace {

/// The loop of the window.
class Loop {
 public:
  Loop(live::LiveSession& session, SessionWindows& window, const ConsoleSettings& settings)
      : session_(session),
        window_(window),
        settings_(settings),
        frames_(session, settings.trial, settings.caption),
        operation_(session) {}

  /// False when the user has ended the session.
  bool Turn() {
    const double now_s = 1e-9 * static_cast<double>(MonotonicNs());
    session_.images().Refresh();
    const live::LiveImage& image = session_.images().Front();
    const camera::CameraTracker* tracker = session_.video();
    const auto video = tracker == nullptr ? nullptr : tracker->Latest();
    if (image.number > 0) {
      frames_.SetNotice(operation_.NoticeAt(now_s));
      const DisplayFrame& frame = frames_.Make(image, video.get(), operation_.steers_probe());
      tip_to_target_mm_ = frame.tip_to_target_mm;
      window_.Show(frame);
      if (num_shown_++ == 0) first_shown_ns_ = MonotonicNs();
      last_shown_ns_ = MonotonicNs();
    }
    window_.HandleEvents();
    if (!operation_.Obey(window_.TakeCommands(), image, now_s)) return false;
    operation_.Move(window_.TakeHandInput(), tip_to_target_mm_, now_s);
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
  live::LiveSession& session_;
  SessionWindows& window_;
  const ConsoleSettings& settings_;
  FrameMaker frames_;
  SessionOperation operation_;
  std::optional<double> tip_to_target_mm_;
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
