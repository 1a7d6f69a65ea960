// Centrelines of vessels and bowel, from a file or from a label map.
#pragma once

#include <filesystem>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/scene/effects/tubes/tube.h"

namespace acus::effects {

/// Reads a CSV with columns vessel (any text), x_mm, y_mm, z_mm (CT space) and radius_mm: the
/// points of each vessel one after the other.
/// @throws InputError with file and row for a vessel of one point or a radius that is not above 0.
std::vector<Centreline> ReadCentrelines(const std::filesystem::path& path);

/// Follows the cross-sections of a tissue from slice to slice of a label map. For vessels that run
/// mostly across the slices: parts that lie in a slice are omitted, as are vessels in fewer than
/// five slices or thinner than a voxel.
std::vector<Centreline> CentrelinesOf(const volume::LabelMap& labels, volume::Label tissue);

}  // namespace acus::effects
