// Files that name the values of label maps: JSON, tables, label descriptions of other programs.
#pragma once

#include <filesystem>

#include "acus/data/volume/value_names.h"

namespace acus::volume {

struct NamesBeside {
  ValueNames names;  ///< Empty if there is no such file.
  std::filesystem::path file;
};

/// Looks for names of values beside a label map, in this order: a file of the same name (`map.tsv`,
/// `map.csv`, `map.txt`, `map.label`, `map.lut`, `map.ctbl`, `map_ColorTable.ctbl` for
/// `map.nii.gz`); `dseg.tsv` of BIDS; a JSON file of the same name; `dataset.json` (nnU-Net) and
/// `metadata.json` (a MONAI bundle) in its folder and the one above; `labels.txt` (ITK-SNAP) in its
/// folder; a stack of MITK (`*.mitklabel.json`) in its folder that has it as image.
/// @throws InputError if one of them is broken, see NamesInFile. Files that name no values are
///     passed over.
NamesBeside FindNamesBeside(const std::filesystem::path& label_map);

/// The names in a JSON file: `labels` or the whole document, as {"1": "spleen"}, {"spleen": 1},
/// {"1": {"name": "spleen"}} or [{"value": 1, "name": "spleen"}]; the channels of a MONAI bundle's
/// output; the segments of dcmqi; the groups of an MITK stack. Or those in a table (label_table.h).
/// Empty if the file names no values.
/// @throws InputError if the file is broken, one of its values is no integer or has two names, or
///     its labels are regions of several values (nnU-Net).
ValueNames NamesInFile(const std::filesystem::path& file);

}  // namespace acus::volume
