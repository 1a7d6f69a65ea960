// Closed surface to label map.
#pragma once

#include "acus/data/mesh/surface.h"
#include "acus/data/volume/volume.h"

namespace acus::meshing {

/// Label map of cubic voxels around the surface; a voxel has `label` if its centre is inside: the
/// surface winds around it (counted along +x), so that overlaps do not become holes.
/// @throws InputError if it would have more than 400 million voxels.
volume::LabelMap VoxelsInside(const mesh::Surface& surface, double spacing_mm, volume::Label label);

}  // namespace acus::meshing
