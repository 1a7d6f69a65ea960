// acus-devices: stands in for a tracker that is not there, over OpenIGTLink.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/data/session/session_import.h"
#include "acus/rig/camera/mannequin_images.h"
#include "acus/rig/tracking/simulators/scripted_hand.h"

namespace {
using namespace acus::simulators;

struct Options {
  std::filesystem::path session, stereo;
  std::optional<double> rate_hz;
  bool loop = false;
  std::vector<double> entry_mm = {0, 0, 0}, target_mm = {0, 0, -60};
  HandScript script;
  std::vector<std::string> names = {ToolNames().needle, ToolNames().probe};
  std::vector<std::filesystem::path> camera;
  std::vector<std::string> faults;
  PlaybackOptions playback;
};

std::unique_ptr<ToolMotion> Motion(const Options& options, bool from_session,
                                   acus::RunContext& context) {
  const ToolNames names{.needle = options.names[0], .probe = options.names[1]};
  if (!from_session) {
    HandScript script = options.script;
    script.entry_mm = Eigen::Vector3d::Map(options.entry_mm.data());
    script.target_mm = Eigen::Vector3d::Map(options.target_mm.data());
    script.rate_hz = options.rate_hz.value_or(script.rate_hz);
    return ScriptedHand(script, names, context.seed);
  }
  auto session = acus::session::ReadAnySession(options.session, {}, context).session;
  auto motion = options.rate_hz ? ResampledMotion(std::move(session), names, *options.rate_hz)
                                : RecordedMotion(std::move(session), names);
  return options.loop ? ForthAndBack(std::move(motion)) : std::move(motion);
}

void SayPort(int port) {
  std::cout << "listening on port " << port << std::endl;  // At once: others wait for it.
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  PlaybackOptions& playback = options.playback;
  CLI::App app{
      "Stand in for a tracker: send the poses of a recorded session, or of a scripted hand,\n"
      "to every OpenIGTLink client (TRANSFORM, and TDATA on request). Prints the port.\n"
      "Ends at the end of the recording, after --seconds, or with Ctrl-C.",
      "acus-devices"};
  app.require_subcommand(1);
  CLI::App* play = app.add_subcommand("play", "Play a recorded session");
  play->add_option("session", options.session, "Session folder, PLUS .igs.mha or Slicer scene")
      ->required()
      ->check(CLI::ExistingPath);
  play->add_flag("--loop", options.loop, "Forth and back without end");
  CLI::App* hand = app.add_subcommand("hand", "Insert a needle again and again");
  hand->add_option("--entry", options.entry_mm, "On the skin: x y z, mm")->expected(3);
  hand->add_option("--target", options.target_mm, "Of the needle: x y z, mm")->expected(3);
  hand->add_option("--insertion-mm-s", options.script.insertion_mm_s, "Mean speed of the tip");
  hand->add_option("--tremor-mm", options.script.tremor_mm, "RMS of each axis");
  app.add_option("--host", playback.server.host, "Address to listen on, else localhost; '' is all");
  app.add_option("--port", playback.server.port, "0 chooses a free one")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  app.add_option("--rate-hz", options.rate_hz, "Poses a second; as recorded, or 100 of the hand")
      ->check(CLI::Range(0.1, 5000.0));
  app.add_option("--speed", playback.speed, "Times the recorded speed")
      ->check(CLI::Range(0.01, 100.0));
  app.add_option("--seconds", playback.seconds, "End after this")->check(CLI::Range(0.0, 1e7));
  app.add_option("--names", options.names, "Needle and probe in the messages")->expected(2);
  app.add_flag("--wait", playback.wait_for_client, "Begin when the first client is there");
  app.add_flag("--send-validity", playback.server.send_validity,
               "Say what is not seen, as PLUS does with protocol 3; else leave it out");
  app.add_option("--fault", options.faults,
                 "What goes wrong, when and how long, s: drop, freeze, occlude, nan, jump (50 mm)\n"
                 "or garbage, as in occlude@5:2; may be given again")
      ->check(FaultProblem);
  app.add_option("--camera", options.camera, "Send images: a camera and facets, files or presets")
      ->expected(2);
  app.add_option("--stereo", options.stereo,
                 "Both cameras of this pair (acus-stereo) in place of the one: VideoRight too");
  app.footer(
      "EXAMPLE\n"
      "  acus-devices play session --port 0 --seconds 1 --fault occlude@0.2:0.3\n"
      "  acus-devices hand --port 0 --seconds 1 --entry 0 0 20 --target 0 0 -60");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    for (const std::string& fault : options.faults) playback.faults.push_back(ParseFault(fault));
    const auto motion = Motion(options, play->parsed(), context);
    playback.on_listening = SayPort;
    const auto images = MannequinImages(options.camera, options.stereo);
    std::cout << Text(Play(*motion, images.get(), playback, context));
    return acus::ExitCode::kOk;
  });
}
