// The inner surface of the wall of the trunk: what slides when a patient breathes lies within.
#pragma once

#include <optional>
#include <vector>

#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// One slice of the trunk: its middle, the front of the spine and of the skin; grid numbers.
struct TrunkSlice {
  bool body = false;  ///< Of the trunk: its skin lies in front of the spine.
  double middle_x = 0.0;
  double spine_y = 0.0;
  double front_y = 0.0;
  bool spine = false;
};

/// The trunk on a grid of 3 mm along the axes of CT space.
struct TrunkWall {
  static constexpr double kGridMm = 3.0;

  volume::Grid<volume::Label> labels;
  std::vector<TrunkSlice> slices;
  Mask inside;  ///< Within ribs and abdominal wall.
};

/// Finds the wall on rays from the middle of the trunk, in every slice: behind the lung; in front
/// of ribs, sternum and spine; where there is neither, 12 mm under the subcutaneous fat in front
/// and from its surroundings elsewhere.
/// @param labels  In standard labels. @returns nothing if they have no spine.
std::optional<TrunkWall> FindTrunkWall(const volume::LabelMap& labels, int num_threads);

}  // namespace acus::segmentation
