// Closed surfaces to voxels, by scan lines.
#pragma once

#include "acus/data/mesh/closed_surface.h"
#include "acus/data/mesh/surface.h"
#include "acus/data/volume/volume.h"

namespace acus::segmentation {

using mesh::CheckClosed;
using mesh::Winding;

/// Sets every voxel of `labels` whose centre is inside the surface to `label`. Lines run along i.
/// Lines through nodes and edges are decided as if moved by next to nothing, alike for all
/// triangles, so that no crossing is lost or counted twice. O(triangles + lines + voxels inside).
/// @param surface  In the frame of the grid: LPS, mm.
/// @pre labels' axes are those of LPS (direction is the identity).
void PaintInside(const mesh::Surface& surface, Winding winding, volume::Label label,
                 int num_threads, volume::LabelMap& labels);

}  // namespace acus::segmentation
