// Displacement fields on disk, as ITK writes them: three numbers for each voxel.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/data/volume/geometry.h"

namespace acus::volume {

/// Displacements in CT space (LPS), mm.
struct DisplacementField {
  Geometry geometry;
  std::vector<float> displacement_in_ct_mm;  ///< (x, y, z) of each voxel, i fastest.
  std::vector<std::string> notes = {};       ///< What was assumed when it was read.
};

/// Reads NIfTI, NRRD or MetaImage with vectors of three floats or doubles.
/// @throws InputError if the file is broken, holds no vectors of three, or a displacement that is
///     not finite.
DisplacementField ReadDisplacementField(const std::filesystem::path& path);

/// Writes the same, by extension; compressed; not atomically.
void WriteDisplacementField(const std::filesystem::path& path, const DisplacementField& field);

}  // namespace acus::volume
