#include "acus/patient/segmentation/muscle_smoothing.h"

#include <algorithm>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/crop.h"

namespace acus::segmentation {
namespace {

constexpr double kHalfStreakMm = 1.5;  ///< Of the thickest fat or muscle that is smoothed away.
constexpr double kLeastMuscleBodyMl = 1.0;

}  // namespace

void SmoothMuscles(const volume::CtVolume& ct, double fat_upper_hu, int num_threads,
                   volume::LabelMap& labels) {
  const volume::Label muscle = volume::LabelOf("muscle"), fat = volume::LabelOf("fat"),
                      soft = volume::LabelOf("soft_tissue");
  const Mask whole = MaskOf(labels, muscle);
  if (Count(whole) == 0) return;
  Box box = BoundsOf(whole);
  const Eigen::Array3i margin = (3.0 / labels.geometry.spacing_mm).ceil().cast<int>() + 1;
  box.low = (box.low - margin).max(0);
  box.high = (box.high + margin).min(labels.geometry.size - 1);
  const Mask before = Cropped(whole, box);
  // At least to the next voxel, so that single ones go in coarse volumes as well.
  const double reach_mm = std::max(kHalfStreakMm, 1.01 * labels.geometry.spacing_mm.minCoeff());
  const Mask closed = Closed(before, reach_mm, num_threads);
  Mask solid = closed;
  const volume::Grid<volume::Label> part = Cropped<volume::Label>(labels, box);
  // Bone and ligaments carry a muscle that is thin beside them.
  for (std::size_t n = 0; n < solid.voxels.size(); ++n) {
    const volume::Label here = part.voxels[n];
    if (here != fat && here != soft && here != muscle) solid.voxels[n] = here != 0 ? 1 : 0;
  }
  solid = Opened(solid, reach_mm, num_threads);
  for (std::size_t n = 0; n < solid.voxels.size(); ++n) {
    const volume::Label here = part.voxels[n];
    const bool may_change = here == fat || here == soft || here == muscle;
    solid.voxels[n] = may_change && closed.voxels[n] != 0 ? solid.voxels[n] : 0;
  }
  const double ml = labels.geometry.voxel_volume_mm3() / 1000.0;
  const Components parts = ConnectedComponents(solid);
  const Mask after = Kept(parts, [&](std::int32_t number) {
    return static_cast<double>(parts.num_voxels[static_cast<std::size_t>(number)]) * ml >=
           kLeastMuscleBodyMl;
  });
  for (int k = box.low[2]; k <= box.high[2]; ++k) {
    for (int j = box.low[1]; j <= box.high[1]; ++j) {
      for (int i = box.low[0]; i <= box.high[0]; ++i) {
        volume::Label& here = labels.At(i, j, k);
        if (here != fat && here != soft && here != muscle) continue;
        if (after.At(i - box.low[0], j - box.low[1], k - box.low[2]) != 0) {
          here = muscle;
        } else if (here == muscle) {
          here = ct.At(i, j, k) < fat_upper_hu ? fat : soft;
        }
      }
    }
  }
}

}  // namespace acus::segmentation
