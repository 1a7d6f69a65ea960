// acus-regression: recorded sessions whose outcome is to stay.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/assess/regression/bisect.h"
#include "acus/assess/regression/new_suite.h"
#include "acus/assess/regression/regression_report.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_main.h"

namespace {

namespace fs = std::filesystem;
using namespace acus::regression;

acus::ExitCode Run(const Suite& suite, const fs::path& output, const fs::path& junit,
                   acus::RunContext& context) {
  acus::AtomicFolder folder(output, context.overwrite);
  const SuiteResult result = RunSuite(suite, folder.path(), context);
  WriteResult(folder.path(), result, context);
  folder.Commit();
  if (!junit.empty()) WriteJUnit(junit, result);
  std::cout << TextOf(result) << "Page: " << (output / "regression.html").string() << std::endl;
  if (result.passed()) return acus::ExitCode::kOk;
  throw acus::NoAnswerError(AdviceText(result));
}

}  // namespace

int main(int argc, char** argv) {
  fs::path suite_path, output, junit, result, run_a, run_b;
  std::vector<std::string> cases, changes;
  CLI::App app{
      "Replay a suite of recorded sessions and hold each run against what is expected of it;\n"
      "make such a suite.\n"
      "Exit code 0 if all are as expected, 4 if one moved, is new or gave no result.",
      "acus-regression"};
  app.require_subcommand(1);
  auto* make = app.add_subcommand("new", "Make a suite from recorded sessions");
  const auto make_suite = AddNewSuiteOptions(*make);
  auto* run = app.add_subcommand("run", "Replay and compare");
  auto* accept = app.add_subcommand("accept", "Make a result the expected outcome, as it is");
  for (CLI::App* command : {run, accept}) {
    command
        ->add_option("suite", suite_path,
                     "Suite (acus-regression JSON), or the folder of suite.json")
        ->required()
        ->check(CLI::ExistingPath);
    command->add_option("--case", cases, "Only this case; may be given several times");
  }
  run->add_option("-o,--output", output, "Folder to make: regression.html, .json, all runs")
      ->required();
  run->add_option("--junit", junit, "XML file to make, for servers that run tests (JUnit)");
  run->add_option("--set", changes,
                  "Change one value of the scenario of every case for this run:\n"
                  "/json/pointer=value; =null takes it out. The result cannot be accepted");
  accept->add_option("result", result, "Folder that acus-regression run made")
      ->required()
      ->check(CLI::ExistingDirectory);
  auto* bisect = app.add_subcommand(
      "bisect", "Find the first step, stage and variable in which two runs with --trace differ");
  bisect->add_option("run_a", run_a, "Run folder of acus-replay --trace")
      ->required()
      ->check(CLI::ExistingDirectory);
  bisect->add_option("run_b", run_b, "The same replay by another build, machine or setting")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.footer(
      "EXAMPLE\n"
      "  acus-regression run suite -o result || true\n"
      "  acus-regression accept suite result\n"
      "  acus-regression run suite -o second_result\n"
      "  acus-regression new scenario.json session --ct ct.nrrd --labels labels.seg.nrrd \\\n"
      "    --transform ct_from_reference.tfm -o new_suite");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    if (bisect->parsed()) {
      const Bisection found = Bisect(run_a, run_b);
      std::cout << TextOf(found) << std::flush;
      if (found.same()) return acus::ExitCode::kOk;
      throw acus::NoAnswerError("the runs differ");
    }
    if (make->parsed()) {
      std::cout << make_suite(context) << std::flush;
      return acus::ExitCode::kOk;
    }
    const Suite suite = With(Only(ReadSuite(suite_path), cases), changes);
    context.provenance.AddInput(fs::is_directory(suite_path) ? suite_path / "suite.json"
                                                             : suite_path);
    if (run->parsed()) return Run(suite, output, junit, context);
    std::cout << AcceptResult(suite, result) << std::flush;
    return acus::ExitCode::kOk;
  });
}
