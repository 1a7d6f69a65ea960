// acus-tradeoff: what accuracy costs in time.
#include <CLI/CLI.hpp>
#include <iostream>

#include "core/run_main.h"
#include "fidelity/goal.h"
#include "fidelity/scene_command.h"
#include "tradeoff/enough.h"
#include "tradeoff/tradeoff_report.h"

int main(int argc, char** argv) {
  std::filesystem::path folder;
  bool quick = false;
  std::string accuracy;
  CLI::App app{
      "Turn knobs of fidelity, and report error and time of each setting from the same run: the\n"
      "knobs of a scenario over a recorded session, or those of one model on a scene of its own.",
      "acus-tradeoff"};
  app.require_subcommand(1);
  const auto run_scene = acus::fidelity::AddSceneOptions(
      *app.add_subcommand("scene", "The knobs of a scenario, over a session"));
  for (const acus::tradeoff::Sweep& sweep : acus::tradeoff::Sweeps()) {
    CLI::App* command =
        app.add_subcommand(std::string(sweep.name), std::string(sweep.title) + ", by itself");
    command
        ->add_option("-o,--output", folder,
                     "Folder to make: tradeoff.csv, tradeoff.json, tradeoff.svg, tradeoff.html")
        ->required();
    command->add_flag("--quick", quick, "Few and coarse settings: seconds instead of minutes");
    command->add_option("--accuracy", accuracy,
                        "Say which setting is enough: force=0.05N, root mean square");
  }
  app.footer(
      "EXAMPLE\n"
      "  acus-tradeoff tissue --quick -o tradeoff\n"
      "  acus-tradeoff tissue --quick --accuracy force=0.05N -o meshes\n"
      "  acus-tradeoff scene scenario.json session --ct ct.nrrd --labels labels.seg.nrrd \\\n"
      "    --transform ct_from_reference.tfm --seconds 2 --knob step_rate_hz=500,2000 -o "
      "scene_tradeoff\n"
      "  With --knob needle_nodes=15,50 in a scene with a bendable needle, or --knob "
      "elevation_planes\n"
      "  in one with ultrasound by beams, the last line says what is lost.");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    const std::string name = app.get_subcommands().front()->get_name();
    if (name == "scene") {
      std::cout << run_scene(context) << std::flush;
      return acus::ExitCode::kOk;
    }
    // A wrong text is told before minutes go by.
    const double limit_n = accuracy.empty() ? 0.0 : acus::fidelity::ParseForceAccuracyN(accuracy);
    const auto rows =
        acus::tradeoff::SweepToFolder(acus::tradeoff::SweepNamed(name), quick, folder, context);
    std::cout << acus::tradeoff::TableText(rows);
    if (!accuracy.empty()) std::cout << acus::tradeoff::EnoughText(rows, limit_n);
    std::cout << std::flush;
    return acus::ExitCode::kOk;
  });
}
