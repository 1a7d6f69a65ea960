// A label map made elsewhere, with what its file says of its values.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/data/volume/value_names.h"
#include "acus/data/volume/volume.h"

namespace acus::volume {

struct NamedValues {
  Grid<std::int32_t> values;     ///< 0: nothing.
  ValueNames names;              ///< Empty if the file gives none.
  std::string named_by;          ///< "by the label table in its header"; empty without names.
  bool is_named_beside = false;  ///< The names are those of a file beside it.
};

/// One structure: the places of its voxels.
struct NamedMask {
  ValueName name;
  std::vector<std::uint32_t> voxels;
};

/// The voxels of a grid for which `is_in` is true.
/// @throws InputError naming `label` if the grid has more than 2^32 - 1 voxels.
template <typename Is>
std::vector<std::uint32_t> VoxelsWhere(const Grid<std::int32_t>& grid, const std::string& label,
                                       const Is& is_in) {
  ACUS_REQUIRE(grid.voxels.size() < 0xFFFFFFFFU, label, ": has ", grid.voxels.size(),
               " voxels; masks have less than 2^32");
  std::vector<std::uint32_t> voxels;
  for (std::size_t n = 0; n < grid.voxels.size(); ++n) {
    if (is_in(grid.voxels[n])) voxels.push_back(static_cast<std::uint32_t>(n));
  }
  return voxels;
}

/// One map of several masks: values are 1, 2, ... in their order. Where masks overlap, the one with
/// fewer voxels remains: a tumour in the liver, the liver in the body.
NamedValues Merged(const std::vector<NamedMask>& masks, const Geometry& grid);

/// Reads integer labels (NIfTI, NRRD, MetaImage, VTI, or a DICOM segmentation object) and their
/// names: a NIfTI file's label table, the segments of a `.seg.nrrd` (in one layer or several, which
/// are merged), the label groups of MITK, or the segments of the DICOM object.
/// @throws InputError if the file is broken, cut off or holds no integers.
NamedValues ReadNamedValues(const std::filesystem::path& path);

}  // namespace acus::volume
