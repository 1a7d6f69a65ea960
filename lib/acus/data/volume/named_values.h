// A label map made elsewhere, with what its file says of its values.
#pragma once

#include <filesystem>
#include <string>

#include "acus/data/volume/value_names.h"
#include "acus/data/volume/volume.h"

namespace acus::volume {

struct NamedValues {
  Grid<std::int32_t> values;  ///< 0: nothing.
  ValueNames names;           ///< Empty if the file gives none.
  std::string named_by;       ///< "by the label table in its header"; empty without names.
};

/// Reads integer labels (NIfTI, NRRD, MetaImage, VTI, or a DICOM segmentation object) and their
/// names: a NIfTI file's label table, the segments of a `.seg.nrrd` or of the DICOM object.
/// @throws InputError if the file is broken, cut off or holds no integers.
NamedValues ReadNamedValues(const std::filesystem::path& path);

}  // namespace acus::volume
