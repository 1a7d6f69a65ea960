// acus-launcher: the window that starts sessions.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/core/run_main.h"
#include "acus/run/launcher/launcher.h"

int main(int argc, char** argv) {
  CLI::App app{
      "A window to choose a patient, an exercise and a trainee, and to start the session: with\n"
      "images, the state of the devices, and the trials of the trainee so far.",
      "acus-launcher"};
  const auto run = acus::launcher::AddLauncherOptions(app);
  app.footer(
      "EXAMPLE\n"
      "  acus-launcher workplaces --list\n"
      "  Without --list the window opens.");
  return acus::RunMain(app, argc, argv,
                       [&](acus::RunContext& context) { return run(context, std::cout); });
}
