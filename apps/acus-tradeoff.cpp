// acus-tradeoff: what accuracy costs in time, on a scenario over a recorded session.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/assess/tuning/scene_command.h"
#include "acus/base/core/run_main.h"

int main(int argc, char** argv) {
  CLI::App app{
      "Change a scenario's settings of accuracy, and report error and time of each from the\n"
      "same run.",
      "acus-tradeoff"};
  app.require_subcommand(1);
  const auto run_scene = acus::tuning::AddSceneOptions(
      *app.add_subcommand("scene", "The knobs of a scenario, over a session"));
  app.footer(
      "EXAMPLE\n"
      "  acus-tradeoff scene scenario.json session --ct ct.nrrd --labels labels.seg.nrrd \\\n"
      "    --transform ct_from_reference.tfm --seconds 2 --knob step_rate_hz=500,2000 -o "
      "scene_tradeoff\n"
      "  With --knob needle_nodes=15,50 in a scene with a bendable needle, or --knob "
      "elevation_planes\n"
      "  in one with ultrasound by beams, the last line says what is lost.");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    std::cout << run_scene(context) << std::flush;
    return acus::ExitCode::kOk;
  });
}
