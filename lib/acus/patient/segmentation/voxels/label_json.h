// JSON files beside label maps that name their values.
#pragma once

#include <filesystem>
#include <string>

#include "acus/data/volume/value_names.h"

namespace acus::segmentation {

struct NamesBeside {
  volume::ValueNames names;  ///< Empty if there is no such file.
  std::filesystem::path file;
};

/// Looks for names of values beside a label map, in this order: a JSON file of the same name
/// (`map.json` for `map.nii.gz`); `dataset.json` (nnU-Net) and `metadata.json` (a MONAI bundle) in
/// its folder and the one above. Read are `labels` or the whole document, as
/// {"1": "spleen"} or {"spleen": 1}; the channels of a bundle's output; the segments of dcmqi.
/// @throws InputError if the file of the same name is no JSON, or one of the files gives a value
///     that is not an integer, or gives it twice.
NamesBeside FindNamesBeside(const std::filesystem::path& label_map);

}  // namespace acus::segmentation
