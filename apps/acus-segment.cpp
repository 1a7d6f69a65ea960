// acus-segment: CT to a label map, closed skin and bone surfaces, images and volumes.
#include <CLI/CLI.hpp>
#include <iostream>

#include "acus/base/core/run_main.h"
#include "acus/data/volume/dicom_series.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/atlas/atlas_organs.h"
#include "acus/patient/segmentation/segment_options.h"
#include "acus/patient/segmentation/segmenters/organ_vessels.h"

int main(int argc, char** argv) {
  namespace segmentation = acus::segmentation;
  segmentation::SegmentOptions options;
  CLI::App app{
      "Find the tissues of a CT: body, skin, fat, soft tissue, bone, lung, gas, and organs "
      "from seed points, labelled CTs of other patients, or label maps made elsewhere.",
      "acus-segment"};
  app.footer(
      "Writes labels.seg.nrrd (3D Slicer), body.stl, skin.stl, bone.stl, preview_*.png,\n"
      "report.html, volumes.csv, quality.json; vertebrae.seg.nrrd and vertebrae.csv where there "
      "is\n"
      "a spine.\n"
      "With --compare also agreement.csv: Dice and 95 % surface distance by tissue.\n\n"
      "EXAMPLE\n"
      "  acus-segment ct.nrrd -o segmented\n");
  segmentation::AddSegmentOptions(app, options);

  return acus::RunMain(app, argc, argv, [&](acus::RunContext& context) {
    if (options.list_series) {
      std::cout << acus::volume::SeriesTable(options.ct, context);
      return acus::ExitCode::kOk;
    }
    const auto config = segmentation::ReadSegmentationConfig(options.ConfigPath());
    auto examination = options.ToExamine();
    context.provenance.AddInput(options.ConfigPath());
    context.provenance.AddInput(options.ct);
    const auto imports = options.ToImport(context);
    const auto others = acus::atlas::ReadAtlas(options.atlases, context);
    const auto ct = acus::volume::ReadCt(options.ct, options.series, context);
    auto found = segmentation::SegmentPatient(ct, config, context);
    auto laid = segmentation::LayImports(imports, ct, found.labels, context);
    std::cout << laid.report;
    examination.vertebrae = std::move(laid.vertebrae);
    examination.organs =
        acus::atlas::AddAtlasOrgans(ct, others, config.tissues, found.labels, context);
    if (options.vessels) std::cout << segmentation::AddLiverVessels(ct, found.labels, context);
    auto patient = segmentation::Examine(ct, config, std::move(found), examination, context);
    if (!options.reference.empty()) {
      patient.agreement = CompareWithReference(patient.labels, options.Reference(context), context);
    }
    segmentation::WritePatientFolder(options.folder, ct, patient, config, context);
    for (const std::string& warning : patient.warnings) context.Warn(warning);
    std::cout << SummaryOf(patient);
    if (!patient.agreement.empty()) std::cout << AgreementTable(patient.agreement);
    return acus::ExitCode::kOk;
  });
}
