#include "acus/window/session_series.h"

#include <nlohmann/json.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/monotonic_time.h"
#include "acus/base/translation/translation.h"
#include "acus/window/patient_on_display.h"

namespace acus::window {
namespace {

namespace fs = std::filesystem;

constexpr int kPollMs = 50;
/// Nothing moves meanwhile, and the processor is free for the reports.
constexpr std::int64_t kRedrawNs = 1'000'000'000;
constexpr const char* kWaiting = translation::Marked("Waiting for the next session.");

fs::path FileOf(const fs::path& scenario) {
  return fs::weakly_canonical(fs::absolute(config::FindConfig(scenario, fs::current_path())));
}

}  // namespace

SessionSeries::SessionSeries(const SeriesSettings& settings, RunContext& context,
                             std::ostream& events)
    : settings_(settings), context_(context), events_(events) {
  if (!settings_.headless) {
    loading_ = std::make_unique<LoadingScreen>(settings_.console.window);
  }
  Load(FileOf(settings_.scenario));
  rig_ = std::make_shared<live::Rig>(settings_.devices, live::Rig::Use::kManySessions);
  if (!settings_.headless) OpenWindows();
  rig_->StartTrackers();
}

void SessionSeries::Load(const fs::path& file) {
  Patient patient{file, scenario::ReadScenario(file, settings_.overrides), nullptr,
                  loading_ ? loading_->Shown(context_) : context_};
  patient.scene = std::make_shared<const simulation::Scene>(
      live::LoadLiveScene(patient.scenario, settings_.devices, patient.context));
  windows_.reset();
  patient_ = std::move(patient);
}

void SessionSeries::OpenWindows() {
  const PatientOnDisplay patient =
      PatientOnDisplayOf(patient_->scenario, *patient_->scene, patient_->context);
  windows_.emplace(patient, settings_.console, loading_->Release());
  windows_->ShowText(translation::Translated(kWaiting));
}

void SessionSeries::Report(const nlohmann::json& event) {
  events_ << event.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) << '\n'
          << std::flush;
}

void SessionSeries::Count(ExitCode code) {
  if (worst_ == ExitCode::kOk) worst_ = code;
}

ExitCode SessionSeries::RunOne(const live::SessionRequest& request) {
  const fs::path file =
      request.scenario.empty() ? FileOf(settings_.scenario) : FileOf(request.scenario);
  if (file != patient_->file) Load(file);
  RunContext context = patient_->context;
  live::LiveOptions options;
  options.session_folder = request.output;
  options.duration_s = request.duration_s;
  options.hand = request.hand;
  options.left_handed = request.left_handed;
  if (!request.exercise.empty()) live::UseExercise(request.exercise, options, context);
  live::LiveSession session(patient_->scenario, patient_->scene, rig_, options, context);
  bool complete = false;
  if (settings_.headless) {
    complete = live::RunHeadless(session, context);
  } else {
    if (!windows_ || windows_->closed()) OpenWindows();
    windows_->Restart();
    ConsoleSettings console = settings_.console;
    console.trial = request.trial;
    console.caption = request.caption;
    console.screenshot = request.screenshot;
    complete = RunInWindows(*windows_, session, console).complete;
  }
  const ExitCode code = complete ? ExitCode::kOk : ExitCode::kNoAnswer;
  waiting_drawn_ns_ = 0;
  Report({{"event", "ended"},
          {"output", request.output.string()},
          {"code", static_cast<int>(code)},
          {"message", session.SummaryText()}});
  return code;
}

void SessionSeries::FollowNext(LineReader& requests) {
  const auto refuse = [this](ExitCode code, const char* why) {
    Report({{"event", "refused"}, {"code", static_cast<int>(code)}, {"message", why}});
    Count(code);
  };
  try {
    const auto line = requests.Next(kPollMs);
    if (line) Count(RunOne(live::ParseSessionRequest(*line)));
  } catch (const InputError& error) {
    refuse(ExitCode::kInput, error.what());
  } catch (const fs::filesystem_error& error) {
    refuse(ExitCode::kInput, error.what());
  }
}

/// Keeps the window responsive while no session is requested.
void SessionSeries::ShowWaiting() {
  if (!windows_ || windows_->closed()) return;
  const std::int64_t now_ns = MonotonicNs();
  if (now_ns - waiting_drawn_ns_ >= kRedrawNs) {
    windows_->ShowText(translation::Translated(kWaiting));
    waiting_drawn_ns_ = now_ns;
  } else {
    windows_->HandleEvents();
  }
  windows_->TakeCommands();
  windows_->TakeHandInput();
}

ExitCode SessionSeries::Run(int requests) {
  LineReader lines(requests);
  Report({{"event", "ready"}});
  while (!lines.at_end() && !(context_.stop != nullptr && context_.stop->load())) {
    ShowWaiting();
    FollowNext(lines);
  }
  return worst_;
}

}  // namespace acus::window
