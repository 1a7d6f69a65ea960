// acus-register: the mannequin, its trackers and devices to the patient's CT.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/core/run_main.h"
#include "acus/patient/registration/command_line.h"
#include "acus/scene/frame_registration/frame_task.h"

int main(int argc, char** argv) {
  CLI::App app{
      "Register landmarks rigidly, with the error to expect at a target; or what a subcommand "
      "says.",
      "acus-register"};
  const auto run = acus::registration::AddTasks(app, {acus::frame_registration::AddFrameTask(app)});
  app.footer(
      "EXAMPLE\n"
      "  acus-register --from mannequin.csv --to ct.csv --target target.csv -o registration\n"
      "  acus-register pivot poses -o pointer\n"
      "  acus-register touch touches.csv --pivot pointer/registration.json --known ct.csv -o "
      "touched\n"
      "  acus-register tracker still.csv -o tracker");
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    std::cout << run(context);
    return acus::ExitCode::kOk;
  });
}
