// acus-live: a training session with devices.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/core/run_main.h"
#include "acus/window/live_command.h"

int main(int argc, char** argv) {
  CLI::App app{
      "Run a training session: forces at the rate of the device, images beside it, all of it\n"
      "recorded in a session folder that acus-replay reproduces bit for bit.",
      "acus-live"};
  const auto run = acus::window::AddLiveOptions(app);
  app.footer(
      "EXAMPLE\n"
      "  acus-live scenario.json --devices devices/virtual.json --hand session --headless \\\n"
      "    --duration 2 -o live_session --set /patient/ct=ct.nrrd \\\n"
      "    --set /patient/labels=labels.seg.nrrd --overwrite\n"
      "  acus-replay scenario.json live_session --ct ct.nrrd --labels labels.seg.nrrd "
      "--transform identity -o live_run\n"
      "  live_run/forces.csv is then live_session/forces.csv, byte for byte.");
  return acus::RunMain(app, argc, argv,
                       [&](acus::RunContext& context) { return run(context, std::cout); });
}
