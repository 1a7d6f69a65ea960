// The muscles of the abdominal and chest wall.
#pragma once

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// Gives the label muscle to soft tissue between the subcutaneous fat and the inner surface of the
/// wall of the trunk (FindTrunkWall), and to fat in it that is thinner than 3 mm, so that the wall
/// has no holes. Sheets thinner than 5 mm that lie 2.5 mm from the muscle, such as the inner skin,
/// and parts below 2 ml stay as they are, and so does the back beside the spine (FindBackMuscles).
/// Nothing happens without a spine.
void AddWallMuscles(volume::LabelMap& labels, int num_threads);

}  // namespace acus::segmentation
