// Muscles without the stipple of single voxels of fat and muscle.
#pragma once

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// Streaks of fat in muscle thinner than 3 mm become muscle, sheets of muscle thinner than 3 mm
/// and parts below 1 ml become fat or soft tissue, by what they were: a needle punctures the fascia
/// of a muscle, and neither each septum of fat in it nor each fibre in fat. Only muscle, fat and
/// soft tissue change; skin stays, and so does what is not adjacent to muscle.
/// @param fat_upper_hu  Above it, what was muscle becomes soft tissue.
void SmoothMuscles(const volume::CtVolume& ct, double fat_upper_hu, int num_threads,
                   volume::LabelMap& labels);

}  // namespace acus::segmentation
