// Makes the pages about accuracy and time from stored results; pipelines/accuracy-and-time runs it.
#include <CLI/CLI.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/atomic_file.h"
#include "acus/base/core/run_main.h"
#include "benchmarks/machine.h"
#include "benchmarks/page_folder.h"

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  using acus::benchmarks::Claims;
  fs::path templates = fs::path(ACUS_SOURCE_DIR) / "docs" / "templates";
  fs::path data, folder, machine;
  bool strict = false;
  CLI::App app{"Pages about accuracy and time from stored results.", "accuracy_pages"};
  app.add_option("--templates", templates, "Folder of *.template")->check(CLI::ExistingDirectory);
  app.add_option("--data", data, "Folder of results: SWEEP.csv, machine.json, ...")
      ->check(CLI::ExistingDirectory);
  app.add_option("-o,--output", folder, "Folder for the pages and their figures/")->needs("--data");
  app.add_flag("--strict", strict, "Every claim of the text must hold, every number be there");
  app.add_option("--machine", machine, "Write down this machine instead, to this file");
  app.footer("EXAMPLE\n  accuracy_pages --data docs/data -o pages");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext&) {
    if (!machine.empty()) acus::config::WriteJson(machine, acus::benchmarks::MachineFacts());
    if (folder.empty()) return acus::ExitCode::kOk;
    const auto files = acus::benchmarks::MakePages(templates, data,
                                                   strict ? Claims::kMustHold : Claims::kAreMarked);
    fs::create_directories(folder / "figures");
    for (const auto& [name, text] : files) acus::WriteTextFile(folder / name, text);
    return acus::ExitCode::kOk;
  });
}
