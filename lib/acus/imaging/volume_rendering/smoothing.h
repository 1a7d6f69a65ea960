// A CT without its noise and voxel steps: light falls on slopes taken from it.
#pragma once

#include "acus/data/volume/volume.h"

namespace acus::volume_rendering {

/// Binomial weights 1 2 1 along each axis whose spacing is below 1.5 mm; at the border, the nearest
/// voxel counts for those beyond. The same bits with any number of threads.
volume::CtVolume Smoothed(const volume::CtVolume& ct, int num_threads);

}  // namespace acus::volume_rendering
