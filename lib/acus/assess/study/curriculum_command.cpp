#include "acus/assess/study/curriculum_command.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "acus/assess/study/curriculum.h"
#include "acus/base/config/json_file.h"

namespace acus::study {

std::function<std::string(RunContext& context)> AddCurriculumOptions(CLI::App& command) {
  struct Options {
    std::filesystem::path curriculum;
    std::vector<std::filesystem::path> trials;
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
                  "names; several joined by commas")
      ->required()
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::ExistingDirectory);
  return [options](RunContext& context) {
    const auto file = config::FindConfig(options->curriculum, std::filesystem::current_path());
    const Curriculum curriculum = ReadCurriculum(file);
    return CurriculumText(curriculum, FindTrials(options->trials, context));
  };
}

}  // namespace acus::study
