#include "acus/window/live_command.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <ostream>
#include <unistd.h>

#include "acus/base/config/json_file.h"
#include "acus/base/core/text_table.h"
#include "acus/base/translation/translation.h"
#include "acus/imaging/graphics/gl_context.h"
#include "acus/run/live/image_server.h"
#include "acus/run/replay/replay.h"
#include "acus/window/session_series.h"

namespace acus::window {
namespace {

namespace fs = std::filesystem;

struct Options {
  fs::path scenario, devices, exercise;
  std::vector<std::string> changes;
  bool headless = false;
  bool requests = false;
  std::string make_images;  ///< [HOST:]PORT to listen on; empty: runs the session itself.
  live::LiveOptions session;
  ConsoleSettings console;
  std::string volume_rays = "auto";
};

void AddSessionOptions(CLI::App& app, Options& options) {
  app.add_option("-o,--output", options.session.session_folder, "Session folder to make");
  app.add_option("--hand", options.session.hand,
                 "Virtual hands follow this recorded session and its commands, to its end, or for\n"
                 "--duration forth and back")
      ->check(CLI::ExistingPath);
  app.add_option("--duration", options.session.duration_s, "End by itself after so many seconds")
      ->check(CLI::Range(0.0, 86400.0));
  app.add_flag("--virtual-time", options.session.virtual_time,
               "With --headless and virtual hands only: time is counted, not measured. As fast as\n"
               "the computer is, without images; the recording is the same on every computer");
  app.add_option("--exercise", options.exercise, "What the trainee is asked to do (acus-exercise)")
      ->check(CLI::ExistingFile);
  app.add_option("--trial", options.console.trial,
                 "Which trial of the trainee it is: hints fade with it")
      ->check(CLI::Range(1, 100000));
  app.add_option("--set", options.changes,
                 "Change one value of the scenario: /json/pointer=value; =null takes it out");
  app.add_flag("--left-handed", options.session.left_handed,
               "Exchange the devices of needle and probe that the devices file names");
}

/// What `--volume-rays auto` chooses on this computer.
std::string GraphicsText() {
  try {
    const graphics::GlContext card(graphics::DriverKind::kHardware);
    return "graphics: " + card.Description() + "; renders the volume view";
  } catch (const InputError& error) {
    return std::string("processor: ") + error.what() + "; the processor renders the volume view";
  }
}

void AddWindowOptions(CLI::App& app, Options& options) {
  app.add_flag("--headless", options.headless,
               "Without a window; otherwise there must be a display");
  app.add_option("--views", options.console.views,
                 "Views to show, with commas: camera, ultrasound, 3d, volume, ct, effects.\n"
                 "Without it all but volume, which the key M brings");
  app.add_option("--volume-rays", options.volume_rays,
                 "What renders the volume view: graphics (OpenGL), processor, or auto: a graphics\n"
                 "card, where there is one")
      ->check(CLI::IsMember({"auto", "processor", "graphics"}))
      ->capture_default_str();
  app.add_flag_callback(
         "--graphics", [] { throw CLI::CallForVersion(GraphicsText(), 0); },
         "Print the graphics card, its driver and memory, and whether it renders the volume view")
      ->trigger_on_parse();
  app.add_option("--trainer-views", options.console.trainer_views,
                 "A second window with these views, for a trainer; move it to another screen");
  app.add_option("--screenshot", options.console.screenshot,
                 "PNG of the window, taken at the end; NAME_trainer.png is that of the trainer");
}

std::string VolumeRaysText(const VolumeReadout& volume) {
  return "rays on " + (volume.rays_on.empty() ? "the processor" : volume.rays_on);
}

int NumAsked(const Options& options) {
  const live::LiveOptions& session = options.session;
  return (session.session_folder.empty() ? 0 : 1) + (session.only_checks ? 1 : 0) +
         (options.requests ? 1 : 0) + (options.make_images.empty() ? 0 : 1);
}

/// True if options are given that a request contains.
bool AsksForOneSession(const Options& options) {
  const live::LiveOptions& session = options.session;
  return !options.exercise.empty() || !session.hand.empty() || session.duration_s > 0.0 ||
         session.left_handed || options.console.trial != 1 || !options.console.screenshot.empty();
}

void CheckCombination(const Options& options) {
  if (NumAsked(options) == 0) throw CLI::RequiredError("--output");
  if (!options.make_images.empty() && NumAsked(options) > 1) {
    throw CLI::ValidationError("--make-images goes with none of --output, --check and --requests");
  }
  if (options.session.virtual_time && (!options.headless || options.requests)) {
    throw CLI::ValidationError("--virtual-time goes with --headless, and not with --requests");
  }
  if (!options.requests) return;
  if (NumAsked(options) > 1) {
    throw CLI::ValidationError("--requests goes with neither --output nor --check");
  }
  if (AsksForOneSession(options)) {
    throw CLI::ValidationError(
        "--requests: --exercise, --hand, --duration, --trial, --left-handed and --screenshot are "
        "those of each request");
  }
}

std::vector<scenario::Override> OverridesOf(const Options& options) {
  std::vector<scenario::Override> overrides;
  for (const auto& change : options.changes) overrides.push_back(scenario::ParseOverride(change));
  return overrides;
}

ExitCode RunSeries(const Options& options, const live::LiveDevices& devices, RunContext& context,
                   std::ostream& out) {
  SessionSeries series({.scenario = options.scenario,
                        .overrides = OverridesOf(options),
                        .devices = devices,
                        .console = options.console,
                        .headless = options.headless},
                       context, out);
  return series.Run(STDIN_FILENO);
}

/// Runs as the second computer.
ExitCode MakeImages(const Options& options, const live::LiveDevices& devices, RunContext& context,
                    std::ostream& out) {
  const auto [host, port] = live::ListenAddress(options.make_images);
  const auto scenario = scenario::ReadScenario(
      config::FindConfig(options.scenario, fs::current_path()), OverridesOf(options));
  const simulation::Scene scene = live::LoadLiveScene(scenario, devices, context);
  live::ImageServer server(scene, live::DigestOf(scenario, scene),
                           {.host = host,
                            .port = port,
                            .has_needle = devices.has_needle(),
                            .has_probe = devices.has_probe(),
                            .least_image_rate_hz = options.session.least_image_rate_hz,
                            .duration_s = options.session.duration_s,
                            .on_event = [&out](const std::string& line) {
                              out << line << std::endl;  // At once: a program reads it.
                            }});
  out << "listening on port " << server.port() << std::endl;
  server.Run(context.stop);
  return ExitCode::kOk;
}

ExitCode RunLive(Options& options, RunContext& context, std::ostream& out) {
  translation::UseLanguage(translation::LanguageOfEnvironment(), translation::LocaleFolder());
  const fs::path here = fs::current_path();
  options.console.window.volume_rays = VolumeRaysOf(options.volume_rays);
  const auto devices = live::ReadLiveDevices(config::FindConfig(options.devices, here));
  if (options.requests) return RunSeries(options, devices, context, out);
  if (!options.make_images.empty()) return MakeImages(options, devices, context, out);
  const auto scenario =
      scenario::ReadScenario(config::FindConfig(options.scenario, here), OverridesOf(options));
  if (!options.exercise.empty()) live::UseExercise(options.exercise, options.session, context);
  std::optional<LoadingScreen> loading;
  RunContext shown = context;
  if (!options.headless && !options.session.only_checks) {
    shown = loading.emplace(options.console.window).Shown(context);
  }
  live::LiveSession session(scenario, devices, options.session, shown);
  if (options.session.only_checks) {
    out << replay::CheckText(scenario, {}, replay::PlanDetail::kStages, context)
        << session.DevicesText();
    return ExitCode::kOk;
  }
  bool good = false;
  if (options.headless) {
    good = live::RunHeadless(session, context);
  } else {
    const WindowRun run =
        RunWithWindow(scenario, session, options.console, shown, loading ? &*loading : nullptr);
    good = run.complete;
    out << "Window: " << FixedText(run.frames_per_s, 1) << " frames a second.\n";
    if (run.volume) out << "Volume view: " << VolumeRaysText(*run.volume) << ".\n";
  }
  out << session.SummaryText();
  return good ? ExitCode::kOk : ExitCode::kNoAnswer;
}

}  // namespace

std::function<ExitCode(RunContext& context, std::ostream& out)> AddLiveOptions(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  app.add_option("scenario", options->scenario, "Scenario (acus-scenario JSON): a file or a preset")
      ->required();
  app.add_option("--devices", options->devices,
                 "What is attached (acus-devices JSON): a file, or a preset such as\n"
                 "devices/virtual.json")
      ->required();
  AddSessionOptions(app, *options);
  AddWindowOptions(app, *options);
  app.add_flag("--check", options->session.only_checks,
               "Check scenario, files and devices; start nothing, and load no driver: say which\n"
               "library each device has");
  app.add_flag("--requests", options->requests,
               "Sessions one after the other, as lines of JSON on standard input request them\n"
               "(acus-session-request); devices and window stay open from one to the next.\n"
               "Standard output has a line of JSON when all is ready and when a session ends");
  app.add_option("--make-images", options->make_images,
                 "Be the second computer: make the images of sessions that run elsewhere, whose\n"
                 "devices file names this one in images_from. [HOST:]PORT to listen on, such as\n"
                 ":18946 for the whole network; without a host only this computer hears it");
  app.callback([options] { CheckCombination(*options); });
  return
      [options](RunContext& context, std::ostream& out) { return RunLive(*options, context, out); };
}

}  // namespace acus::window
