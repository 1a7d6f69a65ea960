// Bone that a complete map of bones does not have.
#pragma once

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// Bone in `labels` where `import`, which contains every bone, has none becomes soft tissue:
/// contrast agent, stones, calcified vessels. Pieces that lie mostly more than 30 mm from
/// everything in the import stay, because the import does not reach there: an arm beside the body,
/// a leg.
/// @pre both lie on one grid.
/// @returns how many voxels became soft tissue.
std::size_t DropOtherBones(const volume::LabelMap& import, volume::LabelMap& labels,
                           int num_threads);

}  // namespace acus::segmentation
