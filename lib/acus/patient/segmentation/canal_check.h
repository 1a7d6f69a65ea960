// Whether a spinal canal that was found can be one.
#pragma once

#include <string>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// What was measured of the canal of a label map.
struct CanalCheck {
  double length_mm = 0.0;           ///< Slices with canal.
  double area_mm2 = 0.0;            ///< Mean over these slices.
  double bone_around = 0.0;         ///< Share of what lies within 4 mm around it.
  double beside_middle_mm = 0.0;    ///< Of its centroid, from the median of the bone in its slices.
  std::vector<std::string> doubts;  ///< For people; empty: nothing speaks against it.
};

/// @pre the map has a canal.
CanalCheck CheckCanal(const volume::LabelMap& labels, int num_threads);

}  // namespace acus::segmentation
