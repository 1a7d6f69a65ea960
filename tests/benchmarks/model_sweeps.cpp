// model_sweeps: what accuracy costs in time, for one model by itself.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/assess/tuning/goal.h"
#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "benchmarks/enough.h"
#include "benchmarks/machine.h"
#include "benchmarks/tradeoff_report.h"

int main(int argc, char** argv) {
  std::filesystem::path folder, machine_file;
  bool quick = false;
  std::string accuracy;
  CLI::App app{
      "Change the settings of one model on a scene of its own, and report error and time of\n"
      "each setting from the same run.",
      "model_sweeps"};
  app.require_subcommand(1);
  for (const acus::benchmarks::Sweep& sweep : acus::benchmarks::Sweeps()) {
    CLI::App* command = app.add_subcommand(std::string(sweep.name), std::string(sweep.title));
    command
        ->add_option("-o,--output", folder,
                     "Folder to make: tradeoff.csv, tradeoff.json, tradeoff.svg, tradeoff.html")
        ->required();
    command->add_flag("--quick", quick, "Few and coarse settings: seconds instead of minutes");
    command->add_option("--accuracy", accuracy,
                        "Say which setting is enough: force=0.05N, root mean square");
  }
  CLI::App* machine = app.add_subcommand("machine", "Write down the machine that runs the sweeps");
  machine->add_option("-o,--output", machine_file, "File of facts to write, JSON")->required();
  app.footer(
      "EXAMPLE\n"
      "  model_sweeps tissue --quick -o tradeoff\n"
      "  model_sweeps tissue --quick --accuracy force=0.05N -o meshes");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    if (machine->parsed()) {
      acus::config::WriteJson(machine_file, acus::benchmarks::MachineFacts());
      return acus::ExitCode::kOk;
    }
    const std::string name = app.get_subcommands().front()->get_name();
    // A wrong text is an error before minutes go by.
    const double limit_n = accuracy.empty() ? 0.0 : acus::tuning::ParseForceAccuracyN(accuracy);
    const auto rows =
        acus::benchmarks::SweepToFolder(acus::benchmarks::SweepNamed(name), quick, folder, context);
    std::cout << acus::benchmarks::TableText(rows);
    if (!accuracy.empty()) std::cout << acus::benchmarks::EnoughText(rows, limit_n);
    std::cout << std::flush;
    return acus::ExitCode::kOk;
  });
}
