// Vessels inside an organ, by the contrast agent in them.
#pragma once

#include <string>

#include "acus/base/core/run_context.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::segmentation {

/// What a search for vessels found in an organ.
struct OrganVessels {
  Mask vessels;            ///< On the grid of the CT; empty unless is_found.
  bool is_found = false;   ///< Bright lines are there, and far more of them than dark ones.
  std::string reason;      ///< Why not; for people.
  double organ_hu = 0.0;   ///< Median of the organ.
  double vessel_hu = 0.0;  ///< Of the wider vessels.
  double noise_hu = 0.0;   ///< Standard deviation of the organ.
  double vessel_ml = 0.0;  ///< What the search finds.
  double bright_ml = 0.0;  ///< Of it, voxels that are certain to be on a line.
  double dark_ml = 0.0;    ///< As many as these the same search finds in the inverted CT.
};

/// Finds vessels by lines brighter than the organ (LineResponse), with radii of 1.4 to 5.6 mm, and
/// by HU: see docs/models/segmentation.md. Noise makes as many bright as dark lines, so that the
/// search in the inverted CT measures how much of the result is noise; vessels without contrast
/// agent are darker than the organ. In both cases nothing is found, with a reason.
/// @param organ  Where vessels are looked for, 1 inside: the organ with the vessels in it, without
///     lesions. @throws InputError if it lies on another grid than the CT.
OrganVessels FindVesselsIn(const volume::CtVolume& ct, const Mask& organ, int num_threads);

/// Gives the label vessel to the vessels of the liver in `labels`, where that is liver or soft
/// tissue that the liver encloses. Warns if there are none.
/// @returns a line for people. @throws InputError if `labels` has no liver.
std::string AddLiverVessels(const volume::CtVolume& ct, volume::LabelMap& labels,
                            const RunContext& context);

}  // namespace acus::segmentation
