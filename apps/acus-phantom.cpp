// acus-phantom: synthetic patients with known truth, and scenes on other patients.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/phantom/approach_window.h"
#include "acus/patient/phantom/breathing_folder.h"
#include "acus/patient/phantom/liver_ducts.h"
#include "acus/patient/phantom/patient_folder.h"
#include "acus/patient/segmentation/patient_segmentation.h"

namespace {

struct DuctOptions {
  acus::phantom::LiverDuctSettings settings;
  std::vector<double> lesion_at_mm, root_at_mm;
};

/// The subcommand's options beside its CT and labels.
void AddDuctOptions(CLI::App& app, DuctOptions& options) {
  acus::phantom::LiverDuctSettings& s = options.settings;
  app.add_option("--vessel-mm", s.vessel_mm, "Diameter of the vessel's root; 0: no vessels")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  app.add_option("--duct-mm", s.duct_mm, "Diameter of the bile duct's root; 0: no ducts")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  app.add_option("--thinnest-mm", s.thinnest_mm, "Diameter below which a branch does not fork")
      ->check(CLI::Range(0.6, 60.0))
      ->capture_default_str();
  app.add_option("--margin-mm", s.margin_mm, "To the liver's border and between structures")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  app.add_option("--lesion-mm", s.lesion_mm, "Diameters of the lesion along x y z; 0 0 0: none");
  app.add_option("--lesion-at", options.lesion_at_mm, "Its centre x y z (CT, LPS, mm); or random")
      ->expected(3);
  app.add_option("--root-at", options.root_at_mm,
                 "Both trees begin near x y z (CT, LPS, mm); default: the middle of the liver")
      ->expected(3);
  for (const auto& [name, value] : {std::pair{"--vessel-hu", &s.vessel_hu},
                                    {"--duct-hu", &s.duct_hu},
                                    {"--lesion-hu", &s.lesion_hu}}) {
    app.add_option(name, *value, "Mean HU inside")
        ->check(CLI::Range(-1000.0, 3000.0))
        ->capture_default_str();
  }
}

acus::phantom::LiverDuctSettings SettingsOf(const DuctOptions& options) {
  acus::phantom::LiverDuctSettings settings = options.settings;
  const auto point = [](const std::vector<double>& xyz) -> std::optional<Eigen::Vector3d> {
    if (xyz.empty()) return {};
    return Eigen::Vector3d(xyz[0], xyz[1], xyz[2]);
  };
  settings.lesion_at_mm = point(options.lesion_at_mm);
  settings.root_at_mm = point(options.root_at_mm);
  return settings;
}

}  // namespace

int main(int argc, char** argv) {
  std::string kind, series;
  std::filesystem::path config_path, labels_path, ct_path, folder;
  acus::phantom::BreathingFolderSettings breath;
  acus::phantom::SceneRequest request;
  CLI::App app{"Make a synthetic patient with exact truth, or a scene on another patient.",
               "acus-phantom"};
  app.footer(
      "EXAMPLE\n"
      "  acus-phantom patient lumbar --seed 1 -o patient\n"
      "  acus-phantom scene patient/labels.seg.nrrd -o scene\n"
      "  acus-phantom scene patient/labels.seg.nrrd --target liver --window subcostal -o biopsy\n"
      "  acus-phantom warp liver_patient/ct.nrrd --phases 4 -o moving\n"
      "  acus-phantom ducts liver_patient/ct.nrrd --labels liver_patient/labels.seg.nrrd -o "
      "ducts\n");
  app.require_subcommand(1);
  app.fallthrough();
  CLI::App* patient = app.add_subcommand(
      "patient", "CT, label map, truth, markers, target, force curves and a session at 1 kHz");
  const char* kinds =
      "lumbar (puncture at L3/L4), liver (biopsy of a lesion), liver_ptc (drainage of a bile "
      "duct), "
      "kidney (nephrostomy), shoulder (puncture of the bursa), and shoulder_effusion, "
      "shoulder_calcification, shoulder_tear";
  patient->add_option("kind", kind, kinds)
      ->required()
      ->check(CLI::IsMember({"lumbar", "liver", "liver_ptc", "kidney", "shoulder",
                             "shoulder_effusion", "shoulder_calcification", "shoulder_tear"}));
  CLI::App* scene = app.add_subcommand(
      "scene", "Markers, target and a session on the label map of any patient; finds a free path");
  const char* labels_help = "Label map, such as acus-segment's labels.seg.nrrd";
  scene->add_option("labels", labels_path, labels_help)->required()->check(CLI::ExistingFile);
  scene->add_option(
      "--target", request.target,
      "A structure of the label map, such as liver, kidney_left or spinal_canal (its\n"
      "deepest point that a free path reaches), or a point x,y,z (CT, LPS, mm)");
  scene->add_option("--window", request.window, "From where; default: as usual for the target")
      ->check(CLI::IsMember(acus::phantom::WindowNames()));
  CLI::App* warp = app.add_subcommand(
      "warp", "A 4D CT with exactly known motion from one CT, taken as end expiration");
  const char* ct_help = "CT: DICOM folder, .nii.gz, .nrrd, .mha";
  warp->add_option("ct", ct_path, ct_help)->required()->check(CLI::ExistingPath);
  CLI::App* ducts = app.add_subcommand(
      "ducts", "Vessels, bile ducts and a lesion in the liver of a CT that shows none");
  ducts->add_option("ct", ct_path, ct_help)->required()->check(CLI::ExistingPath);
  ducts->add_option("--series", series, "Which series of a DICOM folder");
  ducts->add_option("--labels", labels_path, "Its tissues; default: found as acus-segment does")
      ->check(CLI::ExistingFile);
  ducts->add_option("-o,--output", folder, "Folder to write")->required();
  DuctOptions duct_options;
  AddDuctOptions(*ducts, duct_options);
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
  const char* config_help = "Settings (format acus-phantom/1); default: the preset";
  for (CLI::App* command : {patient, scene}) {
    command->add_option("--config", config_path, config_help)->check(CLI::ExistingFile);
    command->add_option("-o,--output", folder, "Folder to write")->required();
  }

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    if (warp->parsed()) {
      context.provenance.AddInput(ct_path);
      const auto ct = acus::volume::ReadCt(ct_path, series, context);
      const auto tissues = acus::segmentation::TissuesOf(ct, labels_path, context);
      acus::phantom::WriteBreathingPatient(folder, ct, tissues, breath, context);
      std::cout << acus::phantom::BreathingFolderText(breath);
      return acus::ExitCode::kOk;
    }
    if (ducts->parsed()) {
      context.provenance.AddInput(ct_path);
      const auto ct = acus::volume::ReadCt(ct_path, series, context);
      const auto tissues = acus::segmentation::TissuesOf(ct, labels_path, context);
      const auto settings = SettingsOf(duct_options);
      const auto made = acus::phantom::PutDuctsIntoLiver(ct, tissues, settings, context);
      acus::phantom::WriteLiverDucts(folder, made, settings, context);
      std::cout << acus::phantom::LiverDuctsText(made);
      return acus::ExitCode::kOk;
    }
    if (config_path.empty()) {
      const bool requests = !request.target.empty() || !request.window.empty();
      const std::string preset = !scene->parsed() ? kind : requests ? "scene_target" : "scene";
      config_path = acus::config::FindConfig("phantoms/" + preset + ".json", ".");
    }
    context.provenance.AddInput(config_path);
    const auto config = acus::phantom::ReadPhantomConfig(config_path);
    if (scene->parsed()) {
      context.provenance.AddInput(labels_path);
      std::cout << acus::phantom::WriteScene(folder, acus::volume::ReadTissues(labels_path), config,
                                             context, request);
    } else {
      std::cout << acus::phantom::WritePatient(folder, config, context);
    }
    return acus::ExitCode::kOk;
  });
}
