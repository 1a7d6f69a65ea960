#include "acus/patient/segmentation/segment_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "acus/base/config/json_file.h"

namespace acus::segmentation {
namespace {

/// What the options say of the label map with this number.
ForeignLabels Foreign(const std::filesystem::path& file, std::size_t number,
                      const SegmentOptions& options, RunContext& context) {
  ForeignLabels labels{.file = file,
                       .mapping = {},
                       .ct = options.ct,
                       .series = options.series,
                       .accept_other_frame = options.accept_implausible};
  if (!options.mappings.empty()) {
    labels.mapping = options.mappings[std::min(number, options.mappings.size() - 1)];
    context.provenance.AddInput(labels.mapping);
  }
  context.provenance.AddInput(file);
  return labels;
}

}  // namespace

std::filesystem::path SegmentOptions::ConfigPath() const {
  return config.empty() ? config::FindConfig("segmentation/default.json", ".") : config;
}

Examination SegmentOptions::ToExamine() const {
  Examination examination{.certainty = certainty, .start = {}};
  if (!vertebra.empty()) examination.start = ParseVertebra(vertebra);
  return examination;
}

ImportOptions SegmentOptions::ToImport(RunContext& context) const {
  ImportOptions out{.maps = {}, .accept_implausible = accept_implausible};
  for (const auto& path : imports) {
    out.maps.push_back(Foreign(path, out.maps.size(), *this, context));
  }
  return out;
}

ForeignLabels SegmentOptions::Reference(RunContext& context) const {
  return Foreign(reference, 0, *this, context);
}

void AddSegmentOptions(CLI::App& app, SegmentOptions& options) {
  app.add_option("ct", options.ct, "DICOM folder, or a NIfTI, NRRD or MetaImage file")
      ->required()
      ->check(CLI::ExistingPath);
  app.add_option(
         "--config", options.config,
         "Settings (format acus-segmentation/1); default: the preset segmentation/default.json")
      ->check(CLI::ExistingFile);
  app.add_option("--series", options.series,
                 "DICOM series: its UID, or a part of that or of its description");
  auto* list_option =
      app.add_flag("--list-series", options.list_series, "Only list the series of the DICOM folder")
          ->excludes("--series");
  auto* import_option =
      app.add_option("--import", options.imports,
                     "Label map made elsewhere, or a folder with one mask for each structure, laid "
                     "over the tissues found; may be given several times, the last remains")
          ->allow_extra_args(false)
          ->check(CLI::ExistingPath);
  auto* compare_option = app.add_option("--compare", options.reference,
                                        "Reference label map to hold the result against")
                             ->check(CLI::ExistingPath)
                             ->excludes(import_option);
  auto* mapping_option =
      app.add_option(
             "--mapping", options.mappings,
             "What the values of that label map mean: a file that names them (label description "
             "of ITK-SNAP, colour table of 3D Slicer, dataset.json, ...), or format "
             "acus-label-mapping/1, by value, or acus-label-names/1, by name; one for all or one "
             "for each --import; default: the names that the map gives, otherwise "
             "label_maps/acus.json for "
             ".seg.nrrd, else label_maps/totalsegmentator.json")
          ->allow_extra_args(false)
          ->check(CLI::ExistingFile);
  auto* accept_option = app.add_flag("--accept-implausible", options.accept_implausible,
                                     "Take a map although it cannot be of this patient, or is in "
                                     "another frame of reference: only warn");
  app.add_option("--atlas", options.atlases,
                 "Folder with labelled CTs of other patients (atlas.json): liver, kidneys, spleen; "
                 "may be given several times, all patients count")
      ->allow_extra_args(false)
      ->check(CLI::ExistingDirectory);
  app.add_flag("--vessels", options.vessels,
               "Find the vessels inside the liver of a CT with contrast agent; the liver must be "
               "known by --atlas, --import or a seed");
  app.add_option("--vertebra", options.vertebra,
                 "Name of one vertebra and a point of its body, CT mm, such as L3=-2.5,110,140");
  app.add_flag("--certainty", options.certainty,
               "Also say where the labels depend on the thresholds; takes three times as long");
  app.add_option("-o,--output", options.folder, "Folder to write");
  app.callback(
      [&options, list_option, mapping_option, accept_option, import_option, compare_option] {
        if (options.folder.empty() && list_option->count() == 0)
          throw CLI::RequiredError("--output");
        const bool has_map = import_option->count() + compare_option->count() > 0;
        for (const auto* option : {mapping_option, accept_option}) {
          if (option->count() > 0 && !has_map) {
            throw CLI::RequiresError(option->get_name(), "--import or --compare");
          }
        }
        const std::size_t maps = std::max<std::size_t>(options.imports.size(), 1);
        if (options.mappings.size() > 1 && options.mappings.size() != maps) {
          throw CLI::ValidationError("--mapping", "give one for all, or one for each --import");
        }
      });
}

}  // namespace acus::segmentation
