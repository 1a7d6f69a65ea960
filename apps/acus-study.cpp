// acus-study: a study with groups of trainees, from its order to its tables.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/assess/study/study_command.h"
#include "acus/base/core/run_main.h"

int main(int argc, char** argv) {
  CLI::App app{
      "Plan a study of trainees, and report it: groups described and compared, learning,\n"
      "reliability, questionnaires, and the size of the next study.",
      "acus-study"};
  app.require_subcommand(1);
  app.fallthrough();
  const auto run = acus::study::AddStudyCommands(app);
  app.footer(
      "EXAMPLE\n"
      "  acus-study plan studies/simulated.json -o study_plan\n"
      "  acus-study report study.json --trials trainees -o study_report\n"
      "  The page is then study_report/study.html.");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    std::cout << run(context) << std::flush;
    return acus::ExitCode::kOk;
  });
}
