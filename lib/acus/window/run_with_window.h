// A live session with its window.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/run/live/live_session.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/window/loading_screen.h"
#include "acus/window/session_windows.h"

namespace acus::window {

struct ConsoleSettings : WindowsSettings {
  double rate_hz = 30.0;  ///< Of the window; images themselves have their own rate.
  /// PNG of the window, written at the end. Empty: none. See SessionWindows::WriteScreenshots().
  std::filesystem::path screenshot;
  int trial = 1;        ///< Number of the trainee's trial: hints become rarer with it.
  std::string caption;  ///< Below the exercise's name; may be empty.
};

struct WindowRun {
  bool complete = false;                ///< LiveSession::complete().
  double frames_per_s = 0.0;            ///< Frame rate of the window.
  std::optional<VolumeReadout> volume;  ///< At the end, if the volume view is shown.
};

/// Opens the window, starts the session and runs it until it is over or the user ends it. Keys
/// become orders to the session; mouse and arrow keys move virtual hands.
/// @throws InputError if there is no display, or the session does not start.
/// @param loading  Was opened while the session was made; null: no window is open yet.
WindowRun RunWithWindow(const scenario::Scenario& scenario, live::LiveSession& session,
                        const ConsoleSettings& settings, RunContext& context,
                        LoadingScreen* loading = nullptr);

/// The same in open windows, which show the session's patient.
/// @throws InputError if the session does not start.
WindowRun RunInWindows(SessionWindows& windows, live::LiveSession& session,
                       const ConsoleSettings& settings);

}  // namespace acus::window
