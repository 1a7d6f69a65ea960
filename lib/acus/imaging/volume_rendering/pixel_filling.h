// Which pixels of a tile need a ray of their own: from a coarse grid to a fine one, those between
// others that are alike are interpolated (after Levoy 1990).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "acus/imaging/volume_rendering/fragments.h"
#include "acus/imaging/volume_rendering/ray_tile.h"

namespace acus::volume_rendering {

/// Pixels of the first grid are so far apart, each way; those at the tile's last column and row
/// belong to it as well. A power of two.
inline constexpr int kFirstStride = 4;

/// @param wanted  Gets 1 for each pixel of the first grid, else 0; row by row.
void FirstPixels(const TilePlace& tile, std::vector<std::uint8_t>& wanted);

/// The grid of half the stride. A pixel that is not in the grid of `stride` gets what lies between
/// the two or four around it in that, if these differ by no more than the tolerance in each channel
/// and in opacity, and no surface is in it; else it is required.
/// @param fragments_of  By pixel; empty: there are none.
/// @param pixels  Those of the grid of `stride` are known.
/// @param wanted  Gets 1 for each pixel that needs a ray.
void FillBetween(const TilePlace& tile, int stride, float tolerance,
                 std::span<const std::span<const Fragment>> fragments_of,
                 std::span<RayColour> pixels, std::vector<std::uint8_t>& wanted);

}  // namespace acus::volume_rendering
