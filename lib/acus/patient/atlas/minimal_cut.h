// The smoothest region that agrees with a preference for each voxel.
#pragma once

#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::atlas {

/// Minimises sum w |grad u| - sum preference * u over 0 <= u <= 1: the continuous minimal cut
/// (Chan, Esedoglu & Nikolova 2006), by the primal-dual iteration of Chambolle & Pock 2011. Voxels
/// where u > 0.5 are the region. Preferences above 0 are for the region; w >= 0 is what its surface
/// costs at each voxel. Cubic voxels. The same bits for any number of threads.
/// @pre both grids have the same size.
volume::Grid<float> MinimalCut(const volume::Grid<float>& preference,
                               const volume::Grid<float>& surface_cost, int iterations,
                               int num_threads);

}  // namespace acus::atlas
