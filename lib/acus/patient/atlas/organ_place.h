// Where an organ lies that moves on its own: kidneys, in their fat.
#pragma once

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::atlas {

/// The organ's connected parts, each shifted without rotation to where the CT looks most like it:
/// HU of the organ within, others in the shell of 3 to 9 mm around it. Equations:
/// docs/models/segmentation.md. Shifts are whole voxels, at most `along_mm` along the body and half
/// of that across it. Parts of less than a tenth of the organ stay where they are.
/// @param hu, region  On one cubic grid, region where another patient has the organ.
/// @param organ_hu  The most frequent HU of the organ.
segmentation::Mask Placed(const volume::Grid<float>& hu, const segmentation::Mask& region,
                          double organ_hu, double along_mm, int num_threads);

}  // namespace acus::atlas
