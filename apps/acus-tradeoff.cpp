// acus-tradeoff: what accuracy costs in time.
#include <CLI/CLI.hpp>
#include <iostream>

#include "core/run_main.h"
#include "tradeoff/tradeoff_report.h"

int main(int argc, char** argv) {
  std::string name;
  std::filesystem::path folder;
  bool quick = false;
  std::vector<std::string> names;
  for (const acus::tradeoff::Sweep& sweep : acus::tradeoff::Sweeps())
    names.emplace_back(sweep.name);
  CLI::App app{
      "Turn the knobs of a model one by one, and report error and time of each setting from the "
      "same run.",
      "acus-tradeoff"};
  app.add_option("sweep", name, "What to sweep")->required()->check(CLI::IsMember(names));
  app.add_option("-o,--output", folder,
                 "Folder to make: tradeoff.csv, tradeoff.json, tradeoff.svg, tradeoff.html")
      ->required();
  app.add_flag("--quick", quick, "Few and coarse settings: seconds instead of minutes");
  app.footer(
      "EXAMPLE\n"
      "  acus-tradeoff tissue --quick -o tradeoff");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    const auto rows =
        acus::tradeoff::SweepToFolder(acus::tradeoff::SweepNamed(name), quick, folder, context);
    std::cout << acus::tradeoff::TableText(rows) << std::flush;
    return acus::ExitCode::kOk;
  });
}
