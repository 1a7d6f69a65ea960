#include "acus/run/replay/replay.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/cpu_time.h"
#include "acus/base/core/machine.h"
#include "acus/base/core/output_check.h"
#include "acus/base/core/text_table.h"
#include "acus/data/session/integrity.h"
#include "acus/data/session/session_import.h"
#include "acus/run/replay/labelled_images.h"
#include "acus/run/replay/markups.h"
#include "acus/run/replay/motion_bound_metrics.h"
#include "acus/run/replay/pain_sound.h"
#include "acus/run/replay/plan_table.h"
#include "acus/run/replay/run_folder.h"
#include "acus/run/replay/run_warnings.h"
#include "acus/run/replay/trace.h"
#include "acus/run/replay/training_log.h"
#include "acus/scene/simulation/scene.h"

namespace acus::replay {
namespace {

namespace fs = std::filesystem;
using simulation::Scene;

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

/// Removes the values that differ between two runs of the same inputs.
void ForgetTimes(Run& run) {
  for (auto& cost : run.times.cost) cost.seconds = 0.0;
  run.cpu_s.reset();
  run.cost.reset();
}

/// Collects warnings for the report, in addition to printing them.
class WarningsKept {
 public:
  WarningsKept(RunContext& context, std::vector<std::string>& kept)
      : context_(context), before_(context.on_warning) {
    context.on_warning = [&kept, before = before_](std::string_view text) {
      kept.emplace_back(text);
      if (before) before(text);
    };
  }
  /// Also when the run ends with an error: the list no longer exists then.
  ~WarningsKept() { context_.on_warning = std::move(before_); }
  WarningsKept(const WarningsKept&) = delete;
  WarningsKept& operator=(const WarningsKept&) = delete;

 private:
  RunContext& context_;
  std::function<void(std::string_view)> before_;
};

/// Without a registration, poses in another frame would be taken as if they were in the CT.
void RequireRegistration(const scenario::Scenario& scenario, const session::Session& session) {
  using Pointer = nlohmann::json::json_pointer;
  if (session.reference_frame == "CT") return;
  for (const char* key : {"/patient/ct_from_reference", "/patient/ct_from_reference_file"}) {
    if (scenario.effective.contains(Pointer(key))) return;
  }
  throw InputError(Message(scenario.file.string(),
                           ": there is no registration: the poses of the session are in "
                           "the frame ",
                           session.reference_frame,
                           ", not in that of the CT. Give "
                           "--transform FILE of acus-register, or, if the two frames are one, "
                           "--transform identity"));
}

std::string Rounded(double value) {
  return RoundedText(value, 3);
}

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

/// Subtracts the cost of reading the clock from the steps' times. The stages are timed in one step
/// of sixteen: a few us of that remain in the percentile.
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
    RequireTargetOfGoals(*exercise, scenario);
  }
  transforms::Landmarks targets;
  if (folder) targets = TargetsOf(exercise ? &*exercise : nullptr, scenario);
  Run run;
  const WarningsKept kept(context, run.warnings);
  run.session = ReadSessionFor(scenario, session_path, context);
  const simulation::EffectPlan plan = simulation::PlanEffects(scenario, AvailableIn(run.session));
  simulation::RequireFiles(plan, scenario);
  RequireRegistration(scenario, run.session);
  const Scene scene = simulation::LoadScene(scenario, plan, context);
  run.times = simulation::StageTimes(plan);
  const auto pain_sound = PainSoundOf(scenario, context);

  const double begin_s = ProcessCpuSeconds();
  // The steps visit the times of all images in order.
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
  const std::vector<simulation::Snapshot> of_scene = MomentsOfScene(moments);
  run.images = RenderImages(scene, of_scene, run.steps, into, options, &run.times, context,
                            labelled ? &*labelled : nullptr);
  if (labelled) labelled->Finish();
  run.effects = RenderEffectImages(scene, moments, run.steps, into, options, &run.times, context);
  run.cpu_s = ProcessCpuSeconds() - begin_s;
  for (const std::string& warning : RunWarnings(scene, run.steps, of_scene)) {
    context.Warn(warning);
  }
  if (scenario.patient.num_others > 0) {
    run.others = RangeOverPatients(scenario, run.session, AvailableIn(run.session), context);
  }
  if (scenario.evidence) {
    run.cost = CheckCost(*scenario.evidence, std::move(step_cpu_s), run.images.cpu_s);
  }
  run.metrics = MetricsOf(scene, run.session, run.steps, exercise ? &*exercise : nullptr);
  if (scene.breathing) {
    const auto bounds =
        MotionBoundMetrics(*scene.breathing, run.session, run.steps, targets.points_mm);
    run.metrics.insert(run.metrics.end(), bounds.begin(), bounds.end());
  }
  if (exercise) {
    run.assessment = Assess(*exercise, scenario, scene, run.session, run.metrics, context);
    run.assessment->trainee = options.trainee;
    run.metrics = run.assessment->metrics;
  }
  ReplayResult result{PlanText(scene.plan, &run.times), SummaryOf(run, options)};
  if (folder) {
    if (!options.times) ForgetTimes(run);
    WriteRunFolder(folder->path(), scenario, scene, targets, run, context);
    if (pain_sound) WritePainSound(folder->path(), *pain_sound, scene, run.steps);
    if (options.trace) WriteTrace(folder->path() / "trace.csv", run.steps, scene);
    folder->Commit();
  }
  return result;
}

void RequireRunnable(const scenario::Scenario& scenario, const fs::path& session_path,
                     const ReplayOptions& options, RunContext& context) {
  if (!options.run_folder.empty()) RequireFolderCanBeMade(options.run_folder, context.overwrite);
  std::optional<session::Session> session;
  simulation::AvailableInputs available{.needle_poses = true, .probe_poses = true, .breath = true};
  if (!session_path.empty()) {
    session = session::ReadAnySession(session_path, scenario.session, context).session;
    available = AvailableIn(*session);
  }
  const simulation::EffectPlan plan = simulation::PlanEffects(scenario, available);
  simulation::RequireFiles(plan, scenario);
  if (session) RequireRegistration(scenario, *session);
  const Scene scene = simulation::LoadScene(scenario, plan, context);
  PainSoundOf(scenario, context);
  if (options.exercise.empty()) return;
  const training::Exercise exercise = training::ReadExercise(options.exercise);
  RequireAssessable(exercise, scenario, scene, session ? &*session : nullptr);
  RequireTargetOfGoals(exercise, scenario);
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
