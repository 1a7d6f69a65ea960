// A label map made elsewhere, on the grid of a CT, with what its values mean.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/patient/segmentation/import/label_mapping.h"
#include "acus/patient/segmentation/voxels/label_names.h"

namespace acus::segmentation {

/// A label map made elsewhere and the table that translates it.
struct ForeignLabels {
  std::filesystem::path file;  ///< Or a folder, see ReadForeignMap.
  /// Format acus-label-mapping/1 (values) or acus-label-names/1 (names), or a file that names the
  /// values (see NamesInFile), instead of the names that the map gives. Empty: these names and the
  /// preset label_maps/names.json; for a map without names the values of
  /// label_maps/acus.json (.seg.nrrd) or label_maps/totalsegmentator.json.
  std::filesystem::path mapping;
  /// The CT that the map is laid on, and its DICOM series. Where both are DICOM, their frames of
  /// reference must be one.
  std::filesystem::path ct = {};
  std::string series = {};
  bool accept_other_frame = false;  ///< Only warn of another one.
};

struct ImportedLabels {
  std::filesystem::path file;
  volume::Grid<std::int32_t> values;  ///< On the grid of the CT.
  LabelMapping mapping;               ///< Of all values that occur.
  std::string named_by;               ///< "by the label table in its header"
  volume::ValueNames own_names;       ///< Those that the map gives; may be empty.
  LabelNames names;                   ///< What is plausible.
  /// What the values that occur are; those with unknown names are missing.
  std::map<std::int32_t, NamedStructure> structures;
};

/// Reads a label map and finds what its values mean. Warns if that had to be assumed.
/// @throws InputError if a file is broken, the map lies elsewhere, or a value that occurs has no
///     name, or one that is not in the table (all of them are listed).
ImportedLabels ReadImportedLabels(const ForeignLabels& labels, const volume::Geometry& grid,
                                  const RunContext& context);

/// The tissues of an import; 0 where it has none.
volume::LabelMap TissuesIn(const ImportedLabels& import);

/// "labels.nii.gz: 61 structures, by the label table in its header\n"
std::string ImportSentence(const ImportedLabels& import);

}  // namespace acus::segmentation
