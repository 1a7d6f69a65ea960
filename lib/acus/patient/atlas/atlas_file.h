// The file that lists the patients of an atlas.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/patient/segmentation/import/imported_labels.h"

namespace acus::atlas {

/// One patient of an atlas.
struct AtlasPatient {
  std::string name;
  std::filesystem::path ct;
  std::string series;  ///< Of a DICOM folder.
  segmentation::ForeignLabels labels;
};

/// Reads atlas.json (format acus-atlas/1) of each folder; its files become inputs of the
/// provenance. All patients are of one atlas.
/// @throws InputError naming the place in the file, or a CT that is listed twice.
std::vector<AtlasPatient> ReadAtlas(const std::vector<std::filesystem::path>& folders,
                                    RunContext& context);

}  // namespace acus::atlas
