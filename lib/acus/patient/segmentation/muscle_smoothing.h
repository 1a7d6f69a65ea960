// Muscles without the stipple of single voxels of fat and muscle.
#pragma once

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// Parts of fat and soft tissue below 1 ml among muscle become muscle, as does a voxel of them with
/// muscle on four or more of its six sides; parts of muscle below 1 ml
/// become fat or soft tissue, by what they were: a needle punctures the fascia of a muscle, and
/// neither each septum of fat in it nor each fibre in fat. Planes of fat between muscles are
/// connected, and stay. Only muscle, fat and soft tissue change.
/// @param fat_upper_hu  Above it, what was muscle becomes soft tissue.
void SmoothMuscles(const volume::CtVolume& ct, double fat_upper_hu, volume::LabelMap& labels);

}  // namespace acus::segmentation
