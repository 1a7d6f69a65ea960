// acus-phantom: synthetic patients with known truth, and scenes on other patients.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/phantom/breath/breathing_folder.h"
#include "acus/patient/phantom/ducts_task.h"
#include "acus/patient/phantom/patient_folder.h"
#include "acus/patient/segmentation/patient_segmentation.h"

using namespace acus::phantom;

int main(int argc, char** argv) {
  std::string kind, series;
  std::filesystem::path config_path, labels_path, ct_path, folder;
  BreathingFolderSettings breath;
  SceneRequest request;
  CLI::App app{"Make a synthetic patient with exact truth, or a scene on another patient.",
               "acus-phantom"};
  app.footer(
      "EXAMPLE\n"
      "  acus-phantom patient lumbar --seed 1 -o patient\n"
      "  acus-phantom scene patient/labels.seg.nrrd -o scene\n"
      "  acus-phantom scene patient/labels.seg.nrrd --target liver --window subcostal -o biopsy\n"
      "  acus-phantom warp liver_patient/ct.nrrd --phases 4 -o moving\n");
  app.require_subcommand(1)->fallthrough();
  CLI::App* patient = app.add_subcommand(
      "patient", "CT, label map, truth, markers, target, force curves and a session at 1 kHz");
  const char* kinds =
      "lumbar (puncture at L3/L4), liver (biopsy of a lesion), liver_ptc (drainage of a bile "
      "duct), kidney (puncture of its lower half), shoulder (puncture of the bursa), and "
      "shoulder_effusion, shoulder_calcification, shoulder_tear; bursa_injection, nephrostomy "
      "(dilated renal pelvis) "
      "and liver_cyst, for these procedures";
  patient->add_option("kind", kind, kinds)
      ->required()
      ->check(CLI::IsMember({"lumbar", "liver", "liver_ptc", "kidney", "shoulder",
                             "shoulder_effusion", "shoulder_calcification", "shoulder_tear",
                             "bursa_injection", "nephrostomy", "liver_cyst"}));
  CLI::App* scene = app.add_subcommand(
      "scene", "Markers, target and a session on the label map of any patient; finds a free path");
  scene->add_option("labels", labels_path, "Label map, such as acus-segment's labels.seg.nrrd")
      ->required()
      ->check(CLI::ExistingFile);
  request.AddOptions(*scene);
  CLI::App* warp = app.add_subcommand(
      "warp", "A 4D CT with exactly known motion from one CT, taken as end expiration");
  warp->add_option("ct", ct_path, "DICOM folder, .nii.gz, .nrrd, .mha")
      ->required()
      ->check(CLI::ExistingPath);
  const DuctsTask ducts = AddDuctsTask(app);
  warp->add_option("--series", series, "Which series of a DICOM folder");
  warp->add_option("--labels", labels_path, "Its tissues; default: found as acus-segment does")
      ->check(CLI::ExistingFile);
  warp->add_option("--phases", breath.num_phases, "Phases of a breath")->check(CLI::Range(4, 60));
  warp->add_option("--diaphragm-mm", breath.motion.diaphragm_mm, "Travel of the diaphragm")
      ->check(CLI::Range(0.0, 80.0));
  warp->add_option("--chest-mm", breath.motion.chest_mm, "Anterior travel of chest and abdomen")
      ->check(CLI::Range(0.0, 30.0));
  warp->add_option("--hysteresis-mm", breath.motion.hysteresis_mm, "Half the loop's width")
      ->check(CLI::Range(0.0, 20.0));
  warp->add_option("--period-s", breath.motion.period_s, "Of a breath")->check(CLI::Range(.5, 60.));
  warp->add_option("--noise-hu", breath.noise_sd_hu, "Standard deviation, new in every phase")
      ->check(CLI::Range(0.0, 200.0));
  warp->add_option("--landmarks", breath.num_landmarks, "Random points in lung and liver")
      ->check(CLI::Range(0, 100000));
  warp->add_option("-o,--output", folder, "Folder to write")->required();
  for (CLI::App* command : {patient, scene}) {
    command->add_option("--config", config_path, "Settings (acus-phantom/1); default: the preset")
        ->check(CLI::ExistingFile);
    command->add_option("-o,--output", folder, "Folder to write")->required();
  }
  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    if (warp->parsed()) {
      context.provenance.AddInput(ct_path);
      const auto ct = acus::volume::ReadCt(ct_path, series, context);
      const auto tissues = acus::segmentation::TissuesOf(ct, labels_path, context);
      WriteBreathingPatient(folder, ct, tissues, breath, context);
      std::cout << BreathingFolderText(breath);
      return acus::ExitCode::kOk;
    }
    if (ducts.IsChosen()) return ducts.Run(std::cout, context);
    if (config_path.empty()) {
      const std::string preset = !scene->parsed()  ? kind
                                 : request.empty() ? "scene"
                                                   : "scene_target";
      config_path = acus::config::FindConfig("phantoms/" + preset + ".json", ".");
    }
    context.provenance.AddInput(config_path);
    const auto config = ReadPhantomConfig(config_path);
    if (scene->parsed()) context.provenance.AddInput(labels_path);
    request.FindVertebrae(labels_path, context);
    std::cout << (scene->parsed() ? WriteScene(folder, acus::volume::ReadTissues(labels_path),
                                               config, context, request)
                                  : WritePatient(folder, config, context));
    return acus::ExitCode::kOk;
  });
}
