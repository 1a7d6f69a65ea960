// How well two segmentations agree.
#pragma once

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// Dice coefficient 2 |A and B| / (|A| + |B|); 1 if both are empty.
/// @throws InputError if the sizes of the grids differ.
double Dice(const Mask& a, const Mask& b);

/// 95th percentile [mm] of the distances between the surfaces: for every surface voxel of `a` the
/// distance to the nearest surface voxel of `b`, and the other way round, all taken together. A
/// surface voxel is inside and has a face neighbour outside; beyond the border counts as inside.
/// @throws InputError if the sizes differ or a mask has no surface.
double SurfaceDistance95Mm(const Mask& a, const Mask& b, int num_threads);

}  // namespace acus::segmentation
