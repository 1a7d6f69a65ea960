// acus-phantom: synthetic patients with known truth, and scenes on other patients.
#include <CLI/CLI.hpp>

#include "config/json_file.h"
#include "core/run_main.h"
#include "phantom/patient_folder.h"
#include "volume/volume_io.h"

int main(int argc, char** argv) {
  std::string kind;
  std::filesystem::path config_path, labels_path, folder;
  CLI::App app{"Make a synthetic patient with exact truth, or a scene on another patient.",
               "acus-phantom"};
  app.footer(
      "EXAMPLE\n"
      "  acus-phantom patient lumbar --seed 1 -o patient\n"
      "  acus-phantom scene patient/labels.seg.nrrd -o scene\n");
  app.require_subcommand(1);
  app.fallthrough();

  CLI::App* patient = app.add_subcommand(
      "patient", "CT, label map, truth, markers, target, force curves and a session at 1 kHz");
  patient->add_option("kind", kind, "lumbar (puncture at L3/L4) or liver (biopsy of a lesion)")
      ->required()
      ->check(CLI::IsMember({"lumbar", "liver"}));
  CLI::App* scene = app.add_subcommand(
      "scene", "Markers, target and a session on the label map of any patient; finds a free path");
  scene->add_option("labels", labels_path, "Label map, such as acus-segment's labels.seg.nrrd")
      ->required()
      ->check(CLI::ExistingFile);
  for (CLI::App* command : {patient, scene}) {
    command
        ->add_option("--config", config_path,
                     "Settings (format acus-phantom/1); default: the preset")
        ->check(CLI::ExistingFile);
    command->add_option("-o,--output", folder, "Folder to write")->required();
  }

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    if (config_path.empty()) {
      const std::string preset = scene->parsed() ? "scene" : kind;
      config_path = acus::config::FindConfig("phantoms/" + preset + ".json", ".");
    }
    context.provenance.AddInput(config_path);
    const auto config = acus::phantom::ReadPhantomConfig(config_path);
    if (scene->parsed()) {
      context.provenance.AddInput(labels_path);
      acus::phantom::WriteScene(folder, acus::volume::ReadTissues(labels_path), config, context);
    } else {
      acus::phantom::WritePatient(folder, config, context);
    }
    return acus::ExitCode::kOk;
  });
}
