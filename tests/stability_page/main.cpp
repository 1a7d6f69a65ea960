// stability_page: what the tests of developer/stability kept, as a page.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_main.h"
#include "stability_page/stability_report.h"

int main(int argc, char** argv) {
  namespace page = acus::stability_page;
  std::filesystem::path folder, docs;
  CLI::App app{
      "Make stability.html and stability.json of what tests kept in FOLDER/bounds and\n"
      "FOLDER/tests. Exit code 4 if a bound is broken or a test failed.",
      "stability_page"};
  app.add_option("folder", folder, "Folder of developer/stability")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("--docs", docs, "Markdown table to write, too");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    const page::StabilityRun run = page::ReadStabilityRun(folder);
    page::WriteStability(folder, run, context.provenance);
    if (!docs.empty()) acus::WriteTextFile(docs, page::StabilityTable(run, context.provenance));
    for (const auto* value : run.Failing()) {
      std::cout << "FAILS  " << value->origin.module << ": " << value->quantity << " "
                << value->measured << " " << value->unit << ", bound " << value->sense << " "
                << value->bound << "\n";
    }
    for (const auto* test : run.FailedTests()) {
      std::cout << "FAILS  " << test->suite << "." << test->test << "\n";
    }
    for (const auto* program : run.Crashed()) {
      std::cout << "FAILS  " << program->program << ": exit code " << program->exit_code << "\n";
    }
    std::cout << run.values.size() << " values, " << run.Failing().size()
              << " over their bounds: " << (folder / "stability.html").string() << std::endl;
    if (run.AllHold()) return acus::ExitCode::kOk;
    throw acus::NoAnswerError("not all hard cases hold; see " +
                              (folder / "stability.html").string());
  });
}
