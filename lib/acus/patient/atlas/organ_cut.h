// One organ, cut out of a CT near where it is expected.
#pragma once

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::atlas {

/// A part of a CT in which an organ is looked for. All on one cubic grid.
struct OrganSearch {
  volume::Grid<float> hu;
  volume::Grid<float> prior_mm;  ///< Signed distance to where the organ is expected, > 0 inside.
  segmentation::Mask allowed;    ///< Where the organ can be.
};

/// The minimal cut of what HU and prior say of each voxel; its surface costs less at edges of the
/// CT. Parts that are small or do not meet the prior are dropped. Equations:
/// docs/models/segmentation.md.
/// @param organ_hu  The most frequent HU of the organ.
/// @return u in [0, 1], smooth; above 0.5 is the organ.
volume::Grid<float> CutOrgan(const OrganSearch& search, double organ_hu, int num_threads);

}  // namespace acus::atlas
