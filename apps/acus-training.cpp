// acus-training: the sessions of trainees, one after the other.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_main.h"
#include "acus/run/training/progress.h"

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  std::vector<fs::path> runs;
  fs::path output;
  CLI::App app{
      "Put the sessions of an exercise side by side: goals met, values, how they change.\n"
      "Each run folder comes from acus-replay --exercise.",
      "acus-training"};
  app.add_option("runs", runs, "Run folders, in the order of the sessions")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("-o,--output", output, "Folder to make: progress.html, progress.csv");
  app.footer(
      "EXAMPLE\n"
      "  acus-training first_run second_run -o progress\n"
      "  The page is then progress/progress.html.");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    for (const fs::path& run : runs) {
      if (fs::exists(run / "training.json")) context.provenance.AddInput(run / "training.json");
    }
    const auto sessions = acus::training::ReadAssessments(runs);
    if (!output.empty()) {
      acus::AtomicFolder folder(output, context.overwrite);
      acus::training::WriteProgress(folder.path(), sessions, context);
      folder.Commit();
    }
    std::cout << acus::training::ProgressText(sessions) << std::flush;
    return acus::ExitCode::kOk;
  });
}
