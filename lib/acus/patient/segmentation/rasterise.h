// Closed surfaces to voxels, by scan lines.
#pragma once

#include <string>

#include "acus/data/mesh/surface.h"
#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// How the triangles of a surface hang together.
enum class Winding {
  kOriented,    ///< Closed, all triangles face the same way: inside is where it winds around.
  kUnoriented,  ///< Closed, triangles face either way: inside is behind an odd number of crossings.
};

/// @throws InputError naming `label`, the number of open edges and where the first one is, if the
///     surface is not closed; if it has no triangle or a coordinate that is not finite.
Winding CheckClosed(const mesh::Surface& surface, const std::string& label);

/// Sets every voxel of `labels` whose centre is inside the surface to `label`. Lines run along i.
/// Lines through nodes and edges are decided as if moved by next to nothing, alike for all
/// triangles, so that no crossing is lost or counted twice. O(triangles + lines + voxels inside).
/// @param surface  In the frame of the grid: LPS, mm.
/// @pre labels' axes are those of LPS (direction is the identity).
void PaintInside(const mesh::Surface& surface, Winding winding, volume::Label label,
                 int num_threads, volume::LabelMap& labels);

}  // namespace acus::segmentation
