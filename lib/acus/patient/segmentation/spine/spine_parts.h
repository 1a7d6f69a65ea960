// What lies around the spinal canal and follows from its tube and the bone: discs, ligaments, and
// the muscles of the back.
//
// All volumes here have patient axes (lps_axes.h). Lengths in a slice are measured from the
// canal's centre: across (to the left) and back, mm.
#pragma once

#include "acus/patient/segmentation/spine/spinal_canal.h"

namespace acus::segmentation {

/// What the parts are found from. `bone`: dense voxels, before marrow is filled.
struct SpineView {
  const volume::CtVolume& ct;
  const Mask& bone;
  const CanalTube& tube;
  const Mask& canal;
};

/// Gaps of at most 16 mm in the column of vertebral bodies, between two end plates. A gap counts
/// where at least a third of the column has one at the same height, so that loose marrow is none.
Mask FindDiscs(const SpineView& view, double fat_upper_hu);

/// Ligamentum flavum (the first soft tissue behind the canal and its fat, 4 mm thick),
/// interspinous ligaments (in the midline, from there to the tips of the spinous processes) and
/// the supraspinous ligament (over the tips).
Mask FindSpineLigaments(const SpineView& view, double fat_upper_hu);

/// All that is denser than fat behind the vertebral bodies, their transverse processes and the ribs
/// (and the straight lines between these), up to 60 mm from the midline; where it is not bone, it
/// is muscle. Kidneys and lungs lie in front.
Mask FindBackMuscles(const SpineView& view, const Mask& body, double fat_upper_hu);

}  // namespace acus::segmentation
