#include "acus/assess/study/curriculum_command.h"

#include <CLI/CLI.hpp>
#include <memory>
#include <nlohmann/json.hpp>

#include "acus/assess/study/curriculum.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::study {

std::function<std::string(RunContext& context)> AddCurriculumOptions(CLI::App& command) {
  struct Options {
    std::filesystem::path curriculum;
    std::vector<std::filesystem::path> trials;
    std::vector<std::string> trainees;
    bool as_json = false;
  };
  const auto options = std::make_shared<Options>();
  command
      .add_option("curriculum", options->curriculum,
                  "Curriculum (acus-curriculum JSON): a file, or a preset such as\n"
                  "curricula/four_punctures.json")
      ->required();
  command
      .add_option("--trials", options->trials,
                  "Folders that hold training.json of trials at any depth, in the order of their\n"
                  "names; several joined by commas. Discarded sessions do not count")
      ->required()
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::ExistingDirectory);
  command
      .add_option("--trainee", options->trainees,
                  "Codes of the trainees to report, joined by commas, also of those who have no\n"
                  "trial yet; default: all that have one")
      ->delimiter(',')
      ->allow_extra_args(false);
  command.add_flag("--json", options->as_json, "JSON in place of tables, for other programs");
  return [options](RunContext& context) {
    const auto file = config::FindConfig(options->curriculum, std::filesystem::current_path());
    const Curriculum curriculum = ReadCurriculum(file);
    const auto trials = FindTrials(options->trials, context);
    std::set<std::string> codes(options->trainees.begin(), options->trainees.end());
    if (codes.empty()) {
      for (const TrialRecord& trial : trials) codes.insert(trial.code);
      ACUS_REQUIRE(!codes.empty(), options->trials.front().string(),
                   ": no trial was found; give run folders of acus-replay --exercise, or a folder "
                   "of acus-training simulate; or --trainee, for those who have none yet");
    }
    if (options->as_json) return CurriculumJson(curriculum, trials, codes).dump(2) + "\n";
    return CurriculumText(curriculum, trials, codes);
  };
}

}  // namespace acus::study
