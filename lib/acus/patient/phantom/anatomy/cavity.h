// What slides when a patient breathes: everything within ribs and abdominal wall.
#pragma once

#include "acus/base/core/run_context.h"
#include "acus/patient/phantom/anatomy/smooth_level.h"

namespace acus::phantom {

/// The space within the pleura and the peritoneum, and the places that breathing goes by. CT mm,
/// LPS.
struct Cavity {
  SmoothLevel wall;          ///< < 0 in the cavity. Runs on beyond the volume's lower border.
  double dome_z_mm = 0.0;    ///< Height of the diaphragm's domes.
  double top_z_mm = 0.0;     ///< Of the lungs; 160 mm above the domes where the volume cuts them.
  double middle_x_mm = 0.0;  ///< Of the body.
  double spine_front_mm = 0.0;  ///< y of the front of the spine at the height of the domes.
  double skin_front_mm = 0.0;   ///< y of the skin in front, the foremost.
};

/// Finds the wall on rays from the middle of the trunk, in every slice: behind the lung; in front
/// of ribs, sternum and spine; where there is neither, 12 mm under the subcutaneous fat in front
/// and from its surroundings elsewhere. Bone stays outside.
/// @param labels  In standard labels, with bone and, for the diaphragm, lung.
/// @throws InputError if there is no bone, no body, or no lung.
Cavity FindCavity(const volume::LabelMap& labels, const RunContext& context);

/// On the grid of its wall: 1, "cavity", within it.
volume::LabelMap LabelsOf(const Cavity& cavity);

}  // namespace acus::phantom
