// A whole session with a real window, on a display without a screen.
#include "acus/window/run_with_window.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>
#include <sstream>
#include <unistd.h>

#include "acus/base/core/atomic_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/rig/camera/image.h"
#include "acus/window/session_series.h"
#include "support/layered_folder.h"
#include "support/replay_folder.h"
#include "support/virtual_display.h"

namespace acus::window {
namespace {

namespace fs = std::filesystem;

/// Pixels in colours of tissue, which nothing else has.
std::size_t ColouredIn(const fs::path& png) {
  const camera::Image window = camera::ReadImage(png);
  std::size_t coloured = 0;
  for (std::size_t i = 0; i + 2 < window.pixels.size(); i += 3) {
    coloured += window.pixels[i] - window.pixels[i + 2] > 8;
  }
  return coloured;
}

class WindowedSession : public testing_support::ReplayFolder {
 protected:
  void SetUp() override {
    testing_support::WriteLayeredFolder(
        folder_, R"({"needle_force": {}, "ultrasound": {}, "ct_slice": {}})");
    WriteTextFile(folder_ / "devices.json", R"({"format": "acus-devices/1", "devices": [
      {"name": "right", "driver": "virtual_hand", "virtual_hand": {"path": [
        {"time_s": 0, "translation_mm": [0, 20, -5]}, {"time_s": 2, "translation_mm": [0, 20, 25]}]}},
      {"name": "left", "driver": "virtual_hand", "virtual_hand": {"path": [
        {"time_s": 0, "translation_mm": [0, 20, -0.5],
         "quaternion_wxyz": [0.7071067811865476, 0.7071067811865476, 0, 0]}]}}],
      "needle": {"device": "right"}, "probe": {"device": "left"}})");
  }
};

TEST_F(WindowedSession, ShowsRecordsAndReplaysToTheSameForces) {
  const testing_support::VirtualDisplay display(1280, 800);
  live::LiveOptions options;
  options.session_folder = folder_ / "session";
  options.duration_s = 4.0;
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  live::LiveSession session(scenario, live::ReadLiveDevices(folder_ / "devices.json"), options,
                            context_);
  ConsoleSettings settings;
  settings.screenshot = folder_ / "window.png";
  const WindowRun run = RunWithWindow(scenario, session, settings, context_);
  EXPECT_TRUE(run.complete);
  EXPECT_GT(run.frames_per_s, 1.0);
  EXPECT_LT(run.frames_per_s, 32.0);
  EXPECT_EQ(session.end(), live::SessionEnd::kDuration);
  EXPECT_GT(session.statistics().steps, 500);
  EXPECT_GT(session.image_statistics().images, 3);

  // Images are on the screen, and the patient in colours of tissue, which nothing else has.
  const camera::Image window = camera::ReadImage(settings.screenshot);
  EXPECT_EQ(window.width_px, 1280);
  std::size_t bright = 0;
  std::size_t coloured = 0;
  for (std::size_t i = 0; i + 2 < window.pixels.size(); i += 3) {
    const int r = window.pixels[i];
    const int b = window.pixels[i + 2];
    bright += r > 60;
    coloured += r - b > 8;
  }
  EXPECT_GT(bright, 20000);
  EXPECT_GT(coloured, 10000) << bright;

  Run("run", 1);
  EXPECT_EQ(ReadTextFile(folder_ / "run/forces.csv"), ReadTextFile(folder_ / "session/forces.csv"));
}

TEST_F(WindowedSession, ShowsTheVolumeWithTissueUnderTheToolsAndReplaysToTheSameForces) {
  testing_support::WriteLayeredFolder(folder_, R"({"needle_force": {}, "ultrasound": {},
                   "tissue": {"model": "displacement_functions", "pressed_by_probe": true}})");
  const testing_support::VirtualDisplay display(1280, 800);
  live::LiveOptions options;
  options.session_folder = folder_ / "session";
  options.duration_s = 4.0;
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  live::LiveSession session(scenario, live::ReadLiveDevices(folder_ / "devices.json"), options,
                            context_);
  ConsoleSettings settings;
  settings.views = "volume,3d";
  settings.screenshot = folder_ / "window.png";
  EXPECT_TRUE(RunWithWindow(scenario, session, settings, context_).complete);
  EXPECT_EQ(session.statistics().missed_by_computation, 0);
  const camera::Image window = camera::ReadImage(settings.screenshot);
  std::size_t coloured = 0;  // In the left half, where the volume is.
  for (int row = 40; row < 600; ++row) {
    for (int column = 10; column < 600; ++column) {
      const auto at = static_cast<std::size_t>(3 * (row * window.width_px + column));
      coloured += window.pixels[at] - window.pixels[at + 2] > 8;
    }
  }
  EXPECT_GT(coloured, 5000U);
  Run("run", 1);
  EXPECT_EQ(ReadTextFile(folder_ / "run/forces.csv"), ReadTextFile(folder_ / "session/forces.csv"));

  settings.views = "volume,3dd";
  live::LiveOptions again = options;
  again.session_folder = folder_ / "again";
  live::LiveSession other(scenario, live::ReadLiveDevices(folder_ / "devices.json"), again,
                          context_);
  EXPECT_THAT([&] { RunWithWindow(scenario, other, settings, context_); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("there is no view")));
}

/// What a program that asks for sessions is answered.
std::vector<nlohmann::json> EventsIn(const std::string& text) {
  std::vector<nlohmann::json> events;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) events.push_back(nlohmann::json::parse(line));
  return events;
}

TEST_F(WindowedSession, FollowsAnotherInTheSameWindowsAsItIsAskedFor) {
  const testing_support::VirtualDisplay display(1280, 800);
  // Another patient, as far as the series knows.
  fs::copy_file(folder_ / "scene.json", folder_ / "other.json");
  const auto request = [&](const char* name, const char* scenario = "") {
    return nlohmann::json{{"scenario", *scenario == '\0' ? "" : (folder_ / scenario).string()},
                          {"format", "acus-session-request/1"},
                          {"output", (folder_ / name).string()},
                          {"duration_s", 1.5},
                          {"screenshot", (folder_ / Message(name, ".png")).string()}}
               .dump() +
           '\n';
  };
  WriteTextFile(folder_ / "requests",
                request("first") + "what?\n" + request("second") + request("third", "other.json"));
  SeriesSettings settings;
  settings.scenario = folder_ / "scene.json";
  settings.devices = live::ReadLiveDevices(folder_ / "devices.json");
  settings.console.views = "ultrasound";
  settings.console.trainer_views = "3d";
  std::ostringstream events;
  SessionSeries series(settings, context_, events);
  const int requests = ::open((folder_ / "requests").c_str(), O_RDONLY);
  EXPECT_EQ(series.Run(requests), ExitCode::kInput) << "one request is none";
  ::close(requests);

  const auto said = EventsIn(events.str());
  ASSERT_EQ(said.size(), 5U);
  EXPECT_EQ(said[0].at("event"), "ready");
  EXPECT_EQ(said[1].at("output"), (folder_ / "first").string());
  EXPECT_EQ(said[2].at("event"), "refused");
  EXPECT_EQ(said[3].at("output"), (folder_ / "second").string());
  EXPECT_EQ(said[3].at("code"), 0);
  EXPECT_EQ(said[4].at("output"), (folder_ / "third").string());
  for (const char* name : {"first", "second", "third"}) {
    // The trainee sees no 3D view, and the trainer nothing else.
    // What is coloured at the trainee's is at most a line of text.
    const std::size_t at_trainer = ColouredIn(folder_ / Message(name, "_trainer.png"));
    EXPECT_GT(at_trainer, 10000U);
    EXPECT_LT(ColouredIn(folder_ / Message(name, ".png")), at_trainer / 4);
    replay::ReplayOptions replay;
    replay.run_folder = folder_ / "run" / name;
    replay::ReplaySession(scenario::ReadScenario(folder_ / "scene.json", {}), folder_ / name,
                          replay, context_);
    EXPECT_EQ(ReadTextFile(folder_ / name / "forces.csv"),
              ReadTextFile(folder_ / "run" / name / "forces.csv"));
  }
}

TEST_F(WindowedSession, WithoutADisplayItSaysWhatToDo) {
  unsetenv("DISPLAY");
  live::LiveOptions options;
  options.session_folder = folder_ / "session";
  const auto scenario = scenario::ReadScenario(folder_ / "scene.json", {});
  live::LiveSession session(scenario, live::ReadLiveDevices(folder_ / "devices.json"), options,
                            context_);
  EXPECT_THAT([&] { RunWithWindow(scenario, session, {}, context_); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("--headless")));
  EXPECT_FALSE(fs::exists(folder_ / "session"));
}

}  // namespace
}  // namespace acus::window
