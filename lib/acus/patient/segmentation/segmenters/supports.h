// What a patient lies on: tables, boards and headrests that are as dense as tissue.
#pragma once

#include <cstdint>
#include <vector>

#include "acus/data/volume/volume.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// For each of `parts`, whether it is a support: it has the same cross-section in at least 80 % of
/// its voxels over at least 40 mm along `axis`, and less than 1 % of it is as dense as bone, which
/// every limb holds. Parts below `least_ml` are not judged.
std::vector<std::uint8_t> SupportsAmong(const volume::CtVolume& ct, const Components& parts,
                                        double least_ml, int axis);

}  // namespace acus::segmentation
