// acus-segment: CT to a label map, closed skin and bone surfaces, images and volumes.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/data/volume/dicom_series.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/atlas/atlas_organs.h"
#include "acus/patient/segmentation/lay_imports.h"
#include "acus/patient/segmentation/patient_segmentation.h"
#include "acus/patient/segmentation/spine.h"

int main(int argc, char** argv) {
  std::filesystem::path ct_path, config_path, reference_path, folder, atlas;
  std::vector<std::filesystem::path> import_paths, mapping_paths;
  acus::segmentation::ImportOptions imports;
  std::string series;
  bool list_series = false;
  CLI::App app{
      "Find the tissues of a CT: body, skin, fat, soft tissue, bone, lung, gas, and organs "
      "from seed points, labelled CTs of other patients, or label maps made elsewhere.",
      "acus-segment"};
  app.footer(
      "Writes labels.seg.nrrd (3D Slicer), skin.stl, bone.stl, preview_*.png, volumes.csv.\n"
      "With --compare also agreement.csv: Dice and 95 % surface distance by tissue.\n\n"
      "EXAMPLE\n"
      "  acus-segment ct.nrrd -o segmented\n");
  app.add_option("ct", ct_path, "DICOM folder, or a NIfTI, NRRD or MetaImage file")
      ->required()
      ->check(CLI::ExistingPath);
  app.add_option(
         "--config", config_path,
         "Settings (format acus-segmentation/1); default: the preset segmentation/default.json")
      ->check(CLI::ExistingFile);
  app.add_option("--series", series,
                 "DICOM series: its UID, or a part of that or of its description");
  auto* list_option =
      app.add_flag("--list-series", list_series, "Only list the series of the DICOM folder")
          ->excludes("--series");
  auto* import_option =
      app.add_option("--import", import_paths,
                     "Label map made elsewhere, or a folder with one mask for each structure, laid "
                     "over the tissues found; may be given several times, the last remains")
          ->allow_extra_args(false)
          ->check(CLI::ExistingPath);
  auto* compare_option =
      app.add_option("--compare", reference_path, "Reference label map to hold the result against")
          ->check(CLI::ExistingPath)
          ->excludes(import_option);
  auto* mapping_option =
      app.add_option(
             "--mapping", mapping_paths,
             "What the values of that label map mean (format acus-label-mapping/1, by "
             "value, or acus-label-names/1, by name), one for all or one for each --import; "
             "default: the names that the map gives, otherwise label_maps/acus.json for "
             ".seg.nrrd, else label_maps/totalsegmentator.json")
          ->allow_extra_args(false)
          ->check(CLI::ExistingFile);
  app.add_flag("--accept-implausible", imports.accept_implausible,
               "Import a map although it cannot be of this patient: only warn")
      ->needs(import_option);
  app.add_option("--atlas", atlas,
                 "Folder with labelled CTs of other patients (atlas.json): liver, kidneys, spleen")
      ->check(CLI::ExistingDirectory);
  app.add_option("-o,--output", folder, "Folder to write");
  app.callback([&] {
    if (folder.empty() && list_option->count() == 0) throw CLI::RequiredError("--output");
    if (mapping_option->count() > 0 && import_option->count() + compare_option->count() == 0) {
      throw CLI::RequiresError("--mapping", "--import or --compare");
    }
    const std::size_t maps = std::max<std::size_t>(import_paths.size(), 1);
    if (mapping_paths.size() > 1 && mapping_paths.size() != maps) {
      throw CLI::ValidationError("--mapping", "give one for all, or one for each --import");
    }
  });

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    if (list_series) {
      std::cout << acus::volume::SeriesTable(ct_path, context);
      return acus::ExitCode::kOk;
    }
    using acus::config::FindConfig, acus::segmentation::CompareWithReference;
    if (config_path.empty()) config_path = FindConfig("segmentation/default.json", ".");
    const auto config = acus::segmentation::ReadSegmentationConfig(config_path);
    context.provenance.AddInput(config_path);
    context.provenance.AddInput(ct_path);
    // What --mapping says of the label map with this number.
    const auto foreign = [&](const std::filesystem::path& file, std::size_t number) {
      acus::segmentation::ForeignLabels labels{.file = file, .mapping = {}};
      if (!mapping_paths.empty()) {
        labels.mapping = mapping_paths[std::min(number, mapping_paths.size() - 1)];
        context.provenance.AddInput(labels.mapping);
      }
      context.provenance.AddInput(file);
      return labels;
    };
    for (const auto& path : import_paths)
      imports.maps.push_back(foreign(path, imports.maps.size()));
    const auto others = acus::atlas::ReadAtlas(atlas, context);
    const auto ct = acus::volume::ReadCt(ct_path, series, context);
    auto labels = acus::segmentation::SegmentPatient(ct, config, context);
    std::cout << acus::segmentation::LayImports(imports, ct, labels, context);
    acus::atlas::AddAtlasOrgans(ct, others, config.tissues, labels, context);
    std::cout << acus::segmentation::SpineSentence(labels);
    std::vector<acus::segmentation::Agreement> agreement;
    if (!reference_path.empty()) {
      agreement = CompareWithReference(labels, foreign(reference_path, 0), context);
    }
    acus::segmentation::WritePatientFolder(folder, ct, labels, config, agreement, context);
    if (!agreement.empty()) std::cout << acus::segmentation::AgreementTable(agreement);
    return acus::ExitCode::kOk;
  });
}
