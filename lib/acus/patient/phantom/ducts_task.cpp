#include "acus/patient/phantom/ducts_task.h"

#include <CLI/CLI.hpp>
#include <ostream>
#include <vector>

#include "acus/data/volume/volume_io.h"
#include "acus/patient/phantom/anatomy/liver_ducts.h"
#include "acus/patient/segmentation/patient_segmentation.h"

namespace acus::phantom {

struct DuctsTask::Options {
  CLI::App* command = nullptr;
  std::filesystem::path ct, labels, folder;
  std::string series;
  LiverDuctSettings settings;
  std::vector<double> lesion_mm, lesion_at_mm, root_at_mm;
};

namespace {

std::optional<Eigen::Vector3d> PointOf(const std::vector<double>& xyz) {
  if (xyz.empty()) return {};
  return Eigen::Vector3d(xyz[0], xyz[1], xyz[2]);
}

void AddFiles(CLI::App& command, DuctsTask::Options& o) {
  command.add_option("ct", o.ct, "CT: DICOM folder, .nii.gz, .nrrd, .mha")
      ->required()
      ->check(CLI::ExistingPath);
  command.add_option("--series", o.series, "Which series of a DICOM folder");
  command.add_option("--labels", o.labels, "Its tissues; default: found as acus-segment does")
      ->check(CLI::ExistingFile);
  command.add_option("-o,--output", o.folder, "Folder to write")->required();
}

void AddStructures(CLI::App& command, DuctsTask::Options& o) {
  LiverDuctSettings& s = o.settings;
  command.add_option("--vessel-mm", s.vessel_mm, "Diameter of the vessel's root; 0: no vessels")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  command.add_option("--duct-mm", s.duct_mm, "Diameter of the bile duct's root; 0: no ducts")
      ->check(CLI::Range(0.0, 60.0))
      ->capture_default_str();
  command.add_option("--thinnest-mm", s.thinnest_mm, "Diameter below which a branch does not fork")
      ->check(CLI::Range(0.6, 60.0))
      ->capture_default_str();
  command.add_option("--margin-mm", s.margin_mm, "To the liver's border and between structures")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  command
      .add_option("--lesion-mm", o.lesion_mm,
                  "Diameters of the lesion along x y z; 0 0 0: none; 16")
      ->expected(3);
  command
      .add_option("--lesion-at", o.lesion_at_mm, "Its centre x y z (CT, LPS, mm); default: random")
      ->expected(3);
  command
      .add_option("--root-at", o.root_at_mm,
                  "Both trees begin near x y z (CT, LPS, mm); default: the middle of the liver")
      ->expected(3);
  for (const auto& [name, value] : {std::pair{"--vessel-hu", &s.vessel_hu},
                                    {"--duct-hu", &s.duct_hu},
                                    {"--lesion-hu", &s.lesion_hu}}) {
    command.add_option(name, *value, "Mean HU inside")
        ->check(CLI::Range(-1000.0, 3000.0))
        ->capture_default_str();
  }
}

}  // namespace

bool DuctsTask::IsChosen() const {
  return options_->command->parsed();
}

ExitCode DuctsTask::Run(std::ostream& out, RunContext& context) const {
  const Options& o = *options_;
  LiverDuctSettings settings = o.settings;
  settings.lesion_at_mm = PointOf(o.lesion_at_mm);
  settings.root_at_mm = PointOf(o.root_at_mm);
  if (!o.lesion_mm.empty()) settings.lesion_mm = {o.lesion_mm[0], o.lesion_mm[1], o.lesion_mm[2]};
  context.provenance.AddInput(o.ct);
  const volume::CtVolume ct = volume::ReadCt(o.ct, o.series, context);
  const volume::LabelMap tissues = segmentation::TissuesOf(ct, o.labels, context);
  const LiverDucts made = PutDuctsIntoLiver(ct, tissues, settings, context);
  WriteLiverDucts(o.folder, made, settings, context);
  out << LiverDuctsText(made);
  return ExitCode::kOk;
}

DuctsTask AddDuctsTask(CLI::App& app) {
  auto options = std::make_shared<DuctsTask::Options>();
  options->command = app.add_subcommand(
      "ducts", "Vessels, bile ducts and a lesion in the liver of a CT that shows none");
  AddFiles(*options->command, *options);
  AddStructures(*options->command, *options);
  return DuctsTask(std::move(options));
}

}  // namespace acus::phantom
