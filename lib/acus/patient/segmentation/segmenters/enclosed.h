// What a mask surrounds without closing around it.
#pragma once

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// The voxels from which `walls` are seen in at least `least` of the 26 directions to adjacent
/// voxels, within `reach_mm`; walls themselves count if they have as many around them. Looked at on
/// a grid of about 2 mm, or the mask's own if that is coarser. Beyond the border there is nothing.
Mask Enclosed(const Mask& walls, double reach_mm, int least, int num_threads);

}  // namespace acus::segmentation
