// Takes what no element can hold out of a label map.
#pragma once

#include "acus/data/volume/volume.h"
#include "acus/patient/meshing/material_field.h"

namespace acus::meshing {

struct SpeckLimits {
  double speck_mm3 = 0.0;     ///< Smaller pieces of a material go to the tissue around them.
  double island_share = 0.0;  ///< Loose pieces of the body below this share of it become outside.
};

struct CleanedMap {
  volume::LabelMap labels;
  double specks_ml = 0.0;   ///< Voxels that got the label of their surroundings.
  double islands_ml = 0.0;  ///< Loose pieces of the body that were removed.
};

/// Pieces are connected by faces of voxels. A piece of a material smaller than the limit, cavities
/// of the body among them, gets the label that it touches most; what is beyond the volume counts as
/// outside. Pieces that only grow together by that are not looked at again.
CleanedMap WithoutSpecks(const volume::LabelMap& labels, const MaterialOfLabel& material_of_label,
                         const SpeckLimits& limits);

}  // namespace acus::meshing
