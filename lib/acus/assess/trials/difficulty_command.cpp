#include "acus/assess/trials/difficulty_command.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "acus/assess/trials/difficulty.h"
#include "acus/assess/trials/trainee_session.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"

namespace acus::trials {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::vector<fs::path> exercises;
  fs::path trainee = "trainees/novice.json";
  DifficultyOptions judged;
  fs::path output;
};

/// The exercise in the patient that its file names.
TrialScene SceneOf(const fs::path& file, RunContext& context) {
  const training::Exercise exercise = training::ReadExercise(file);
  ACUS_REQUIRE(!exercise.scenario.empty(), file.string(),
               ": /scenario: is missing; name the scenario of the case's patient");
  const fs::path scenario = config::FindConfig(exercise.scenario, file.parent_path());
  context.provenance.AddInput(file);
  context.provenance.AddInput(scenario);
  return LoadTrialScene(scenario::ReadScenario(scenario, {}), file, LikeTrainees(), context);
}

std::string CellOf(const fs::path& file, const fs::path& folder) {
  const std::string cell = fs::relative(file, folder).string();
  ACUS_REQUIRE(cell.find_first_of(",\n#") == std::string::npos, cell,
               ": the path may have no comma and no #, which a table cannot hold");
  return cell;
}

std::string Run(Options& options, RunContext& context) {
  const fs::path here = fs::current_path();
  const fs::path trainee = config::FindConfig(options.trainee, here);
  context.provenance.AddInput(trainee);
  options.judged.grade = ReadTraineeSkill(trainee);
  AtomicFolder folder(options.output, context.overwrite);
  std::string table = "exercise,difficulty,low,high,persons,trials\n";
  std::vector<std::vector<std::string>> rows;
  for (std::size_t n = 0; n < options.exercises.size(); ++n) {
    context.Checkpoint("cases",
                       static_cast<double>(n) / static_cast<double>(options.exercises.size()));
    const fs::path file = fs::weakly_canonical(fs::absolute(options.exercises[n]));
    const TrialScene scene = SceneOf(file, context);
    const Difficulty difficulty =
        DifficultyOf(scene, PlannedPathOf(scene), options.judged, context);
    table += Message(CellOf(file, fs::weakly_canonical(fs::absolute(options.output))), ',',
                     NumberText(difficulty.value), ',', NumberText(difficulty.interval.low), ',',
                     NumberText(difficulty.interval.high), ',', options.judged.persons, ',',
                     options.judged.trials, '\n');
    rows.push_back({scene.exercise.name, FixedText(difficulty.value, 3),
                    FixedText(difficulty.interval.low, 3), FixedText(difficulty.interval.high, 3)});
  }
  WriteTextFile(folder.path() / "cases.csv", table);
  config::WriteJson(folder.path() / "provenance.json", context.provenance.ToJson());
  folder.Commit();
  return TextTable({"case", "difficulty", "from", "to (95 %)"}, rows);
}

}  // namespace

std::function<std::string(RunContext& context)> AddDifficultyOptions(CLI::App& command) {
  const auto options = std::make_shared<Options>();
  command
      .add_option("exercises", options->exercises,
                  "Exercises (acus-exercise JSON), whose scenarios name their patients")
      ->required()
      ->check(CLI::ExistingFile);
  command
      .add_option("--trainee", options->trainee,
                  "Skill (acus-trainee JSON) of the virtual trainees: a file, or a preset")
      ->capture_default_str();
  command.add_option("--persons", options->judged.persons, "Number of virtual trainees")
      ->check(CLI::Range(2, 10000))
      ->capture_default_str();
  command.add_option("--trials", options->judged.trials, "Trials of each")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  command.add_option("--rate-hz", options->judged.rate_hz, "Samples of the needle per second")
      ->check(CLI::Range(50.0, 10000.0))
      ->capture_default_str();
  command
      .add_option("-o,--output", options->output,
                  "Folder to make, with cases.csv: 1 - mean score of each exercise, with an\n"
                  "interval by bootstrap over the trainees")
      ->required();
  return [options](RunContext& context) { return Run(*options, context); };
}

}  // namespace acus::trials
