// Runs sessions one after the other, as another program requests them: devices, trackers, the scene
// and the window stay open from one to the next.
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <ostream>
#include <vector>

#include "acus/base/core/line_reader.h"
#include "acus/base/core/run_context.h"
#include "acus/run/live/live_session.h"
#include "acus/run/live/session_request.h"
#include "acus/scene/scenario/scenario.h"
#include "acus/window/run_with_window.h"

namespace acus::window {

struct SeriesSettings {
  std::filesystem::path scenario;  ///< For requests that name none.
  std::vector<scenario::Override> overrides;
  live::LiveDevices devices;
  ConsoleSettings console;
  bool headless = false;
};

class SessionSeries {
 public:
  /// Loads the scenario, opens devices and window and starts the trackers.
  /// @param context  Must outlive this, as must `events`.
  /// @param events  Receives a line of JSON for each event: {"event": "ready"}, {"event":
  ///     "refused", "code", "message"} for a request that is not possible, {"event": "ended",
  ///     "output", "code", "message"}.
  /// @throws InputError
  SessionSeries(const SeriesSettings& settings, RunContext& context, std::ostream& events);

  /// Carries out the requests of a file descriptor (acus-session-request, one per line) until it
  /// ends or a stop is requested. A session that runs at that time is not cut off.
  /// @returns The code of the first request that failed, or kOk.
  ExitCode Run(int requests);

 private:
  struct Patient {
    std::filesystem::path file;
    scenario::Scenario scenario;
    std::shared_ptr<const simulation::Scene> scene;
    RunContext context;  ///< With the scene's inputs.
  };

  void Load(const std::filesystem::path& file);
  void OpenWindows();
  void FollowNext(LineReader& requests);
  ExitCode RunOne(const live::SessionRequest& request);
  void ShowWaiting();
  void Report(const nlohmann::json& event);
  void Count(ExitCode code);

  SeriesSettings settings_;
  RunContext& context_;
  std::unique_ptr<LoadingScreen> loading_;  ///< Of the first patient; null: without windows.
  std::ostream& events_;
  std::optional<Patient> patient_;
  std::shared_ptr<live::Rig> rig_;
  std::optional<SessionWindows> windows_;
  std::int64_t waiting_drawn_ns_ = 0;  ///< 0: not since the last session.
  ExitCode worst_ = ExitCode::kOk;
};

}  // namespace acus::window
