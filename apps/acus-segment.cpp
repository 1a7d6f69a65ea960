// acus-segment: CT to a label map, closed skin and bone surfaces, images and volumes.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/config/json_file.h"
#include "acus/base/core/run_main.h"
#include "acus/data/volume/dicom_series.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/atlas/atlas_organs.h"
#include "acus/patient/segmentation/patient_segmentation.h"

int main(int argc, char** argv) {
  std::filesystem::path ct_path, config_path, import_path, reference_path, mapping_path, folder,
      atlas;
  std::string series, vertebra;
  bool list_series = false, certainty = false;
  CLI::App app{
      "Find the tissues of a CT: body, skin, fat, soft tissue, bone, lung, gas, and organs "
      "from seed points, labelled CTs of other patients, or a label map made elsewhere.",
      "acus-segment"};
  app.footer(
      "Writes labels.seg.nrrd (3D Slicer), skin.stl, bone.stl, preview_*.png, volumes.csv,\n"
      "quality.json; vertebrae.seg.nrrd and vertebrae.csv where there is a spine.\n"
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
  auto* import_option = app.add_option("--import", import_path,
                                       "Label map made elsewhere, laid over the tissues found")
                            ->check(CLI::ExistingFile);
  auto* compare_option =
      app.add_option("--compare", reference_path, "Reference label map to hold the result against")
          ->check(CLI::ExistingFile)
          ->excludes(import_option);
  auto* mapping_option =
      app.add_option("--mapping", mapping_path,
                     "What the values of that label map mean (format acus-label-mapping/1); "
                     "default: label_maps/acus.json for .seg.nrrd, else "
                     "label_maps/totalsegmentator.json")
          ->check(CLI::ExistingFile);
  app.add_option("--atlas", atlas,
                 "Folder with labelled CTs of other patients (atlas.json): liver, kidneys, spleen")
      ->check(CLI::ExistingDirectory);
  app.add_option("--vertebra", vertebra,
                 "Name of one vertebra and a point of its body, CT mm, such as L3=-2.5,110,140");
  app.add_flag("--certainty", certainty,
               "Also say where the labels depend on the thresholds; takes three times as long");
  app.add_option("-o,--output", folder, "Folder to write");
  app.callback([&] {
    if (folder.empty() && list_option->count() == 0) throw CLI::RequiredError("--output");
    if (mapping_option->count() > 0 && import_option->count() + compare_option->count() == 0) {
      throw CLI::RequiresError("--mapping", "--import or --compare");
    }
  });

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    if (list_series) {
      std::cout << acus::volume::SeriesTable(ct_path, context);
      return acus::ExitCode::kOk;
    }
    using acus::config::FindConfig, acus::segmentation::CompareWithReference;
    if (config_path.empty()) config_path = FindConfig("segmentation/default.json", ".");
    if (mapping_path.empty()) {
      const auto& foreign = import_path.empty() ? reference_path : import_path;
      const bool is_ours = foreign.string().ends_with(".seg.nrrd");
      mapping_path =
          FindConfig(is_ours ? "label_maps/acus.json" : "label_maps/totalsegmentator.json", ".");
    }
    const auto config = acus::segmentation::ReadSegmentationConfig(config_path);
    acus::segmentation::Examination examination{.certainty = certainty, .start = {}};
    if (!vertebra.empty()) examination.start = acus::segmentation::ParseVertebra(vertebra);
    std::optional<acus::segmentation::ForeignLabels> import;
    if (!import_path.empty()) import = {import_path, mapping_path};
    context.provenance.AddInput(config_path);
    context.provenance.AddInput(ct_path);
    for (const auto& path : {import_path, reference_path}) {
      if (path.empty()) continue;
      context.provenance.AddInput(path);
      context.provenance.AddInput(mapping_path);
    }
    const auto others = acus::atlas::ReadAtlas(atlas, context);
    const auto ct = acus::volume::ReadCt(ct_path, series, context);
    auto found = acus::segmentation::SegmentPatient(ct, config, import, context);
    acus::atlas::AddAtlasOrgans(ct, others, config.tissues, found.labels, context);
    auto patient = acus::segmentation::Examine(ct, config, std::move(found), examination, context);
    if (!reference_path.empty()) {
      patient.agreement =
          CompareWithReference(patient.labels, {reference_path, mapping_path}, context);
    }
    acus::segmentation::WritePatientFolder(folder, ct, patient, config, context);
    for (const std::string& warning : patient.warnings) context.Warn(warning);
    std::cout << SummaryOf(patient);
    if (!patient.agreement.empty()) std::cout << AgreementTable(patient.agreement);
    return acus::ExitCode::kOk;
  });
}
