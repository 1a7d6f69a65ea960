#include "acus/assess/tuning/scene_command.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "acus/assess/tuning/budget_command.h"
#include "acus/assess/tuning/result_files.h"
#include "acus/assess/tuning/scene_sweep.h"
#include "acus/assess/tuning/tradeoff_page.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/text_table.h"
#include "acus/base/core/words.h"

namespace acus::tuning {
namespace {

namespace fs = std::filesystem;

/// Everything that options write into.
struct Options {
  std::string scenario;
  fs::path ct;
  fs::path labels;
  fs::path transform;
  std::vector<std::string> changes;
  std::string seconds;
  SweepRequest request;
  BudgetOptions budget;
  fs::path folder;
  std::string only_case;
  bool list = false;
};

/// A stop with its own message: finished runs are kept.
class Stopped : public Cancelled {
 public:
  explicit Stopped(std::string text) : text_(std::move(text)) {}
  const char* what() const noexcept override { return text_.c_str(); }

 private:
  std::string text_;
};

/// "2" or "5:7".
void TakeSeconds(const std::string& text, SweptScene& scene) {
  if (text.empty()) return;
  const std::size_t colon = text.find(':');
  const auto number = [&text](const std::string& part) {
    const auto value = ValueFromText(part);
    ACUS_REQUIRE(value.is_number() && value >= 0.0, "--seconds ", text,
                 ": must be the seconds from the beginning, such as 5, or FROM:TO, such as 2:7");
    return value.get<double>();
  };
  scene.from_s = colon == text.npos ? 0.0 : number(text.substr(0, colon));
  scene.to_s = number(colon == text.npos ? text : text.substr(colon + 1));
  ACUS_REQUIRE(scene.to_s > scene.from_s, "--seconds ", text, ": nothing lies between");
}

SweepRequest RequestOf(const Options& options, const RunContext& context) {
  SweepRequest request = options.request;
  request.seed = context.seed;
  SweptScene& scene = request.scene;
  scene.scenario = config::FindConfig(options.scenario, fs::current_path());
  for (const std::string& change : options.changes) {
    scene.changes.push_back(scenario::ParseOverride(change));
  }
  const auto set_path = [&scene](const char* pointer, const fs::path& path) {
    if (!path.empty()) scene.changes.push_back({pointer, fs::absolute(path).string()});
  };
  set_path("/patient/ct", options.ct);
  set_path("/patient/labels", options.labels);
  set_path("/patient/ct_from_reference_file", options.transform);
  TakeSeconds(options.seconds, scene);
  return request;
}

/// @param store  Null: the folder is not chosen yet.
std::string ListText(const SweepPlan& plan, const RunStore* store) {
  std::string text = LeftOutText(plan);
  for (const Case& one : plan.cases) {
    const bool there = store != nullptr && store->Find(one.name);
    text += Message("case ", one.name, one.is_reference ? "" : " after " + one.reference_case,
                    there ? " (there)" : "", "\n");
  }
  return text;
}

std::string RunQuestion(const Options& options, const SweepRequest& request, RunContext& context) {
  ACUS_REQUIRE(
      !options.list && options.only_case.empty(),
      "--list and --case are for sweeps: which settings a goal needs is determined by the run");
  try {
    return RunBudget(options.budget, request, options.folder, context);
  } catch (const Cancelled&) {
    throw Stopped(
        "stopped on request; finished runs are kept, the same command continues from there");
  }
}

std::string Run(const Options& options, RunContext& context) {
  const SweepRequest request = RequestOf(options, context);
  if (options.budget.AnyGiven()) return RunQuestion(options, request, context);
  const SweepPlan plan = MakePlan(request, context);
  context.provenance.AddInput(plan.request.scene.scenario);
  if (options.list && options.folder.empty()) return ListText(plan, nullptr);
  // With --case, one case is repeated: other processes may run others in the same folder.
  const bool renews = context.overwrite && options.only_case.empty();
  const RunStore store(options.folder, IdentityOf(plan), renews);
  if (options.list) return ListText(plan, &store);
  if (context.overwrite && !renews) store.Forget(options.only_case);
  const Progress before = ProgressOf(plan, store);
  try {
    RunCases(plan, store, options.only_case, context);
  } catch (const Cancelled&) {
    throw Stopped(Message("stopped on request; ", ProgressOf(plan, store).done, " of ",
                          before.planned, " runs are kept, the same command continues from there"));
  }
  if (!options.only_case.empty()) return {};
  const SweepResult result = Collect(plan, store);
  WriteResult(options.folder, result, context);
  PageContent page;
  page.remarks = LinesOf(LeftOutText(plan));
  WritePage(options.folder, result, page, context);
  store.Tidy();
  std::string text = LeftOutText(plan);
  if (before.done > 0) {
    text += Message("Taken up: ", before.done, " of ", before.planned, " runs were there.\n");
  }
  return text + TableText(result) + Sentences(result);
}

void AddSceneAndPatient(CLI::App& command, Options& options) {
  command
      .add_option("scenario", options.scenario,
                  "Scenario (acus-scenario JSON): a file, or a preset such as\n"
                  "scenarios/lumbar_puncture.json")
      ->required();
  command
      .add_option("session", options.request.scene.session,
                  "Session folder, PLUS .igs.mha/.igs.nrrd, or folder of Slicer sequences")
      ->required()
      ->check(CLI::ExistingPath);
  command.add_option("--ct", options.ct, "The patient's CT, in place of the scenario's")
      ->check(CLI::ExistingPath);
  command
      .add_option("--labels", options.labels, "The patient's label map, in place of the scenario's")
      ->check(CLI::ExistingFile);
  command
      .add_option("--transform", options.transform,
                  "ct_from_reference.tfm of acus-register in place of the scenario's, or identity")
      ->check(CLI::ExistingFile | CLI::IsMember({"identity"}));
  command.add_option("--set", options.changes,
                     "Change one value of the scenario: /json/pointer=value; =null takes it out");
}

}  // namespace

std::function<std::string(RunContext& context)> AddSceneOptions(CLI::App& command) {
  auto options = std::make_shared<Options>();
  AddSceneAndPatient(command, *options);
  command.add_option("--knob", options->request.knobs,
                     "A knob to vary: NAME for all its values, NAME=a,b for these. May be given\n"
                     "several times; without it, every knob of what the scene calls for");
  command.add_flag(
      "--jointly", options->request.jointly,
      "Vary the knobs together: all combinations, each against the most expensive one");
  command
      .add_option("--combinations", options->request.most_combinations,
                  "Run at most so many of them: a seeded subset that spreads evenly")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  command
      .add_option("--repetitions", options->request.repetitions,
                  "Runs of each setting; repetition r has the seed --seed + r in all settings")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--seconds", options->seconds,
                     "Of the session: the first S, or FROM:TO. Before FROM it is played, but\n"
                     "neither timed nor compared");
  command
      .add_option("--images", options->request.scene.most_images,
                  "Images of each run at most, evenly over that time")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  AddBudgetOptions(command, options->budget);
  auto* output = command.add_option(
      "-o,--output", options->folder,
      "Folder of the sweep: tradeoff.csv, tradeoff.json, and every run. If it has runs of\n"
      "the same command, only what is missing is run");
  command.add_option("--case", options->only_case, "Run one case only, to run several at a time");
  auto* list = command.add_flag("--list", options->list,
                                "Print the cases, run nothing; with -o, which of them are there");
  command.callback([output, list] {
    if (output->count() == 0 && list->count() == 0) throw CLI::RequiredError("--output");
  });
  return [options](RunContext& context) { return Run(*options, context); };
}

}  // namespace acus::tuning
