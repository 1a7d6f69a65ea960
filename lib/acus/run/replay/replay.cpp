#include "acus/run/replay/replay.h"

#include <algorithm>
#include <optional>

#include "acus/base/config/json_file.h"
#include "acus/base/config/shown_document.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/core/machine.h"
#include "acus/base/core/shown_path.h"
#include "acus/base/core/text_table.h"
#include "acus/data/session/integrity.h"
#include "acus/data/session/session_import.h"
#include "acus/run/replay/cost_check.h"
#include "acus/run/replay/effect_image_log.h"
#include "acus/run/replay/event_log.h"
#include "acus/run/replay/image_log.h"
#include "acus/run/replay/labelled_images.h"
#include "acus/run/replay/markups.h"
#include "acus/run/replay/plan_table.h"
#include "acus/run/replay/run_metrics.h"
#include "acus/run/replay/run_report.h"
#include "acus/run/replay/trace.h"
#include "acus/run/replay/training_log.h"
#include "acus/scene/simulation/plan_json.h"
#include "acus/scene/simulation/scene.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;
using simulation::Scene;
using simulation::StageId;

std::string Rounded(double value) {
  return RoundedText(value, 3);
}

session::Session ReadSessionFor(const scenario::Scenario& scenario, const fs::path& path,
                                RunContext& context) {
  session::Session session = session::ReadAnySession(path, scenario.session, context).session;
  context.provenance.AddInput(path);
  for (const auto& [tool, stream] :
       {std::pair{"needle", &session.needle}, {"probe", &session.probe}}) {
    if (stream->empty()) continue;
    for (const std::string& trouble :
         session::Describe(session::CheckIntegrity(*stream, {}, session.commands), tool)) {
      context.Warn(trouble);
    }
  }
  return session;
}

simulation::AvailableInputs AvailableIn(const session::Session& session) {
  return {.needle_poses = !session.needle.empty(),
          .probe_poses = !session.probe.empty(),
          .breath = !session.breath.empty()};
}

/// Everything that a run gave, before it is written down.
struct Run {
  session::Session session;
  StepLog steps;
  ImageLog images;
  std::vector<EffectImageLog> effects;
  std::vector<Metric> metrics;
  std::optional<training::Assessment> assessment;  ///< If there is an exercise.
  simulation::StageTimes times;
  std::vector<std::string> warnings;
  std::optional<CostCheck> cost;  ///< If the scenario has evidence.
  std::optional<double> cpu_s;    ///< Of steps and images with their writing, all threads.
};

/// Takes out what differs between two runs of the same.
void ForgetTimes(Run& run) {
  for (auto& cost : run.times.cost) cost.seconds = 0.0;
  run.cpu_s.reset();
  run.cost.reset();
}

double SpanSeconds(const session::Session& session) {
  double span_s = 0.0;
  for (const auto* stream : {&session.needle, &session.probe}) {
    if (stream->empty()) continue;
    span_s = std::max(span_s,
                      1e-9 * static_cast<double>(stream->back().time_ns - stream->front().time_ns));
  }
  return span_s;
}

std::vector<std::string> WarningsOf(const Scene& scene, const Run& run) {
  std::vector<std::string> warnings = run.warnings;
  const auto& state = forces::TrackOf(run.steps.final_state.force);
  if (state.num_rejected > 0) {
    warnings.push_back(Message(state.num_rejected, " needle samples were not finite"));
  }
  const auto& probe = forces::GateOf(run.steps.final_state.probe);
  if (probe.num_rejected > 0) {
    warnings.push_back(Message(probe.num_rejected, " probe samples were no poses in a room"));
  }
  const bool felt =
      std::ranges::any_of(run.steps.steps, [](const auto& step) { return step.probe.on_skin; });
  if (scene.plan.Has(StageId::kProbeForce) && !felt) {
    warnings.emplace_back(
        "the probe never touched the skin: is the transform right? On a mannequin that does not "
        "yield it only lies on it; /effects/probe_force/press_mm takes it deeper");
  }
  const auto& rod = run.steps.final_state.shape.needle.rod;
  if (rod.num_not_converged > 0) {
    warnings.push_back(Message("the bendable needle was not quite at rest in ",
                               rod.num_not_converged, " steps; it continued in the next"));
  }
  for (std::string& warning : warnings) warning = ShownText(std::move(warning));
  return warnings;
}

void WriteRunJson(const fs::path& path, const scenario::Scenario& scenario, const Scene& scene,
                  const Run& run, const RunContext& context) {
  nlohmann::json document = {{"format", "acus-run/1"},
                             {"provenance", context.provenance.ToJson()},
                             {"scenario", config::ShownDocument(scenario.effective)},
                             {"session",
                              {{"name", run.session.name},
                               {"needle_samples", run.session.needle.size()},
                               {"probe_samples", run.session.probe.size()},
                               {"seconds", SpanSeconds(run.session)}}},
                             {"images", run.images.num_images},
                             {"effect_plan", simulation::PlanJson(scene.plan, run.times)},
                             {"events", EventsJson(EventsOf(scene, run.steps))},
                             {"warnings", WarningsOf(scene, run)}};
  if (run.cpu_s) {
    document["cpu_seconds"] = *run.cpu_s;
  } else {
    for (auto& stage : document["effect_plan"]) stage.erase("seconds");
  }
  for (const auto& [key, log] : run.effects) document[key + "_images"] = log.num_images;
  if (run.cost) document["cost_check"] = ToJson(*run.cost);
  config::WriteJson(path, document);
}

void WriteRunFolder(const fs::path& folder, const scenario::Scenario& scenario, const Scene& scene,
                    const transforms::Landmarks& targets, const Run& run,
                    const RunContext& context) {
  WriteTargets(folder, targets);
  if (scene.plan.Has(StageId::kNeedleForce)) {
    WriteForces(folder / "forces.csv", run.steps, scene);
    const std::vector<LoggedEvent> events = EventsOf(scene, run.steps);
    WriteEvents(folder / "events.csv", events);
    WriteEventMarkups(folder, events);
  }
  if (scene.plan.Has(StageId::kProbeForce)) {
    WriteProbeForces(folder / "probe_forces.csv", run.steps, scene);
  }
  WriteListedEffects(folder, run.steps, scene);
  WriteMetrics(folder / "metrics.json", run.metrics);
  if (run.assessment) {
    config::WriteJson(folder / "training.json", training::ToJson(*run.assessment));
  }
  WriteRunJson(folder / "run.json", scenario, scene, run, context);
  config::WriteJson(folder / "provenance.json", context.provenance.ToJson());
  ReportContent content;
  content.title = scenario.name.empty() ? "Replay" : scenario.name;
  content.facts = {{"session", run.session.name},
                   {"length of the session", Rounded(SpanSeconds(run.session)) + " s"},
                   {"needle samples", std::to_string(run.session.needle.size())},
                   {"probe samples", std::to_string(run.session.probe.size())},
                   {"images", std::to_string(run.images.num_images)}};
  if (run.cpu_s) content.facts.emplace_back("CPU time of the run", Rounded(*run.cpu_s) + " s");
  if (run.cost) {
    const auto facts = FactsOf(*run.cost);
    content.facts.insert(content.facts.end(), facts.begin(), facts.end());
  }
  content.warnings = WarningsOf(scene, run);
  content.metrics = run.metrics;
  content.assessment = run.assessment;
  const auto add = [&content](const ImageLog& log) {
    content.films.insert(content.films.end(), log.films.begin(), log.films.end());
    content.images.insert(content.images.end(), log.pngs.begin(), log.pngs.end());
  };
  add(run.images);
  for (const EffectImageLog& effect : run.effects) add(effect.log);
  content.times = run.times;
  WriteReport(folder, content, run.steps, scene, context.provenance);
}

/// Keeps what is warned of from now on, for the report, besides telling the user.
class WarningsKept {
 public:
  WarningsKept(RunContext& context, std::vector<std::string>& kept)
      : context_(context), before_(context.on_warning) {
    context.on_warning = [&kept, before = before_](std::string_view text) {
      kept.emplace_back(text);
      if (before) before(text);
    };
  }
  /// Also when the run ends with an error: the list is gone then.
  ~WarningsKept() { context_.on_warning = std::move(before_); }
  WarningsKept(const WarningsKept&) = delete;
  WarningsKept& operator=(const WarningsKept&) = delete;

 private:
  RunContext& context_;
  std::function<void(std::string_view)> before_;
};

std::string SummaryOf(const Run& run, const ReplayOptions& options) {
  std::string text = Message("Replayed ", Rounded(SpanSeconds(run.session)),
                             " s: ", run.steps.steps.size(), " steps, ", run.images.num_images,
                             " images, ", Rounded(run.cpu_s.value_or(0.0)), " s of CPU time.\n");
  for (const Metric& metric : run.metrics) {
    text += Message("  ", metric.name, ": ", Rounded(metric.value), metric.unit.empty() ? "" : " ",
                    metric.unit, "\n");
  }
  if (run.assessment) {
    text += training::GoalsText(*run.assessment);
  }
  if (run.cost) text += TextOf(*run.cost);
  if (!options.run_folder.empty()) {
    text += Message("Report: ", (options.run_folder / "report.html").string(), "\n");
  }
  return text;
}

}  // namespace

std::map<std::string, PngChoice> PngChoices() {
  return {{"events", PngChoice::kEvents}, {"all", PngChoice::kAll}, {"none", PngChoice::kNone}};
}

namespace {

/// Steps without what it took to look at the clock. Their stages are timed in one step of sixteen:
/// that is in the percentile, a few us of it.
CostCheck CheckCost(const scenario::Evidence& evidence, std::vector<double> step_cpu_s,
                    const std::vector<double>& image_cpu_s) {
  const double clock_s = CpuClockCostSeconds();
  for (double& step_s : step_cpu_s) step_s = std::max(0.0, step_s - clock_s);
  return {evidence, CostOf(step_cpu_s, image_cpu_s), MachineName()};
}

}  // namespace

ReplayResult ReplaySession(const scenario::Scenario& scenario, const fs::path& session_path,
                           const ReplayOptions& options, RunContext& context) {
  std::optional<AtomicFolder> folder;
  if (!options.run_folder.empty()) folder.emplace(options.run_folder, context.overwrite);

  std::optional<training::Exercise> exercise;
  if (!options.exercise.empty()) {
    exercise = training::ReadExercise(options.exercise);
    context.provenance.AddInput(options.exercise);
  }
  transforms::Landmarks targets;
  if (folder) targets = TargetsOf(exercise ? &*exercise : nullptr, scenario);
  Run run;
  const WarningsKept kept(context, run.warnings);
  run.session = ReadSessionFor(scenario, session_path, context);
  const simulation::EffectPlan plan = simulation::PlanEffects(scenario, AvailableIn(run.session));
  const Scene scene = simulation::LoadScene(scenario, plan, context);

  const double begin_s = ProcessCpuSeconds();
  // The steps go through the moments of all images in one order of time.
  std::vector<simulation::Snapshot> moments = Snapshots(scene, run.session, &run.times);
  AddOwnMoments(scene, run.session, moments);
  std::vector<double> step_cpu_s;
  run.steps = RunSteps(scene, run.session, moments, &run.times, context,
                       scenario.evidence ? &step_cpu_s : nullptr);
  const fs::path into = folder ? folder->path() : fs::path();
  std::optional<LabelledImages> labelled;
  if (folder && options.labels != LabelFormat::kNone) {
    const auto source = LabelSourceOf(scenario, scene, exercise ? &*exercise : nullptr, context);
    labelled.emplace(scene, source, options.labels, into / "labelled");
  }
  run.images = RenderImages(scene, MomentsOfScene(moments), run.steps, into, options, &run.times,
                            context, labelled ? &*labelled : nullptr);
  if (labelled) labelled->Finish();
  run.effects = RenderEffectImages(scene, moments, run.steps, into, options, &run.times, context);
  run.cpu_s = ProcessCpuSeconds() - begin_s;
  if (scenario.evidence) {
    run.cost = CheckCost(*scenario.evidence, std::move(step_cpu_s), run.images.cpu_s);
  }
  run.metrics = MetricsOf(scene, run.session, run.steps, exercise ? &*exercise : nullptr);
  if (exercise) {
    run.assessment = Assess(*exercise, scenario, scene, run.session, run.metrics, context);
    run.assessment->trainee = options.trainee;
    run.metrics = run.assessment->metrics;
  }
  ReplayResult result{PlanText(scene.plan, &run.times), SummaryOf(run, options)};
  if (folder) {
    if (!options.times) ForgetTimes(run);
    WriteRunFolder(folder->path(), scenario, scene, targets, run, context);
    if (options.trace) WriteTrace(folder->path() / "trace.csv", run.steps, scene);
    folder->Commit();
  }
  return result;
}

void RequireRunnable(const scenario::Scenario& scenario, const fs::path& session_path,
                     const fs::path& exercise, RunContext& context) {
  std::optional<session::Session> session;
  simulation::AvailableInputs available{.needle_poses = true, .probe_poses = true, .breath = true};
  if (!session_path.empty()) {
    session = session::ReadAnySession(session_path, scenario.session, context).session;
    available = AvailableIn(*session);
  }
  const simulation::EffectPlan plan = simulation::PlanEffects(scenario, available);
  const Scene scene = simulation::LoadScene(scenario, plan, context);
  if (exercise.empty()) return;
  RequireAssessable(training::ReadExercise(exercise), scenario, scene,
                    session ? &*session : nullptr);
}

std::string CheckText(const scenario::Scenario& scenario, const fs::path& session_path,
                      PlanDetail detail, RunContext& context) {
  simulation::AvailableInputs available{.needle_poses = true, .probe_poses = true, .breath = true};
  if (!session_path.empty()) {
    const session::Session session = ReadSessionFor(scenario, session_path, context);
    available = AvailableIn(session);
  }
  const simulation::EffectPlan plan = simulation::PlanEffects(scenario, available);
  simulation::RequireFiles(plan, scenario);
  const PlanTable table = TableOfPlan(plan, nullptr);
  return (detail == PlanDetail::kAll ? PlanText(plan, nullptr)
                                     : TextTable(table.header, table.rows)) +
         scenario.file.string() + ": OK\n";
}

}  // namespace acus::replay
