// acus-compare: two runs of acus-replay to a verdict.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/assess/regression/comparison/run_comparison.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_main.h"

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  fs::path run_a, run_b, output;
  bool complete = false;
  fs::path tolerances_path = "tolerances/default.json";
  CLI::App app{
      "Compare two runs: forces, events, images and metrics, each within its tolerance.\n"
      "What only one has is stated: a session of acus-live has no images, its replay in\n"
      "SESSION/report has.\n"
      "Exit code 0 if the runs agree, 4 if they differ.",
      "acus-compare"};
  app.add_option("run_a", run_a,
                 "Run folder of acus-replay, or session of acus-live: the reference")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("run_b", run_b, "Run folder or session to be judged")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("--tolerances", tolerances_path,
                 "Tolerances (acus-tolerances JSON): a file, or a preset such as "
                 "tolerances/identical.json")
      ->capture_default_str();
  app.add_flag("--complete", complete, "What only one of the two has is a difference");
  app.add_option("-o,--output", output, "Folder to make: comparison.html, .json, worst_frame.png");
  app.footer(
      "EXAMPLE\n"
      "  acus-compare reference_run new_run --tolerances tolerances/identical.json -o comparison");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    const fs::path file = acus::config::FindConfig(tolerances_path, fs::current_path());
    context.provenance.AddInput(file);
    for (const fs::path& run : {run_a, run_b}) {
      for (const auto& name : acus::comparison::ComparableFiles(run)) {
        context.provenance.AddInput(run / name);
      }
    }
    const auto tolerances = acus::comparison::ReadTolerances(file);
    const auto lack = complete ? acus::comparison::Lack::kFails : acus::comparison::Lack::kIsStated;
    const auto comparison = acus::comparison::CompareRuns(run_a, run_b, tolerances, lack, context);
    if (!output.empty()) {
      acus::AtomicFolder folder(output, context.overwrite);
      acus::comparison::WriteComparison(folder.path(), comparison, context);
      folder.Commit();
    }
    std::cout << TableText(comparison) << std::flush;
    if (comparison.passed()) return acus::ExitCode::kOk;
    throw acus::NoAnswerError(acus::Message("the runs differ in ", comparison.failed().size(),
                                            " of ", comparison.checks.size(),
                                            " checks, first: ", comparison.failed().front()));
  });
}
