// The names of label values in a header extension of a NIfTI file.
#pragma once

#include <filesystem>

#include "acus/data/volume/value_names.h"

namespace acus::volume {

/// The label table of Connectome Workbench (element LabelTable of CaretExtension), which
/// TotalSegmentator writes as well; 0, the background, is omitted. Empty if the header has no such
/// table.
/// @throws InputError if the table is not valid XML or a key is not an integer.
ValueNames NiftiLabelTable(const std::filesystem::path& path);

}  // namespace acus::volume
