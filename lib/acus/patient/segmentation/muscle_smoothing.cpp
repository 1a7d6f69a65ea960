#include "acus/patient/segmentation/muscle_smoothing.h"

#include <algorithm>

#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::segmentation {
namespace {

constexpr double kLeastPieceMl = 1.0;  ///< Smaller parts of fat and muscle are stipple.

/// True if most of the six voxels around one are of a label.
bool IsAmong(const volume::Grid<volume::Label>& part, std::size_t at, volume::Label label) {
  const auto row = static_cast<std::size_t>(part.geometry.size[0]);
  const std::size_t steps[] = {1, row, row * static_cast<std::size_t>(part.geometry.size[1])};
  int count = 0;
  for (const std::size_t step : steps) {
    if (at >= step) count += part.voxels[at - step] == label ? 1 : 0;
    if (at + step < part.voxels.size()) count += part.voxels[at + step] == label ? 1 : 0;
  }
  return count >= 4;
}

/// Parts of a mask below kLeastPieceMl, or all others.
Mask PartsBySize(const Mask& mask, bool small, double voxel_ml) {
  const Components parts = ConnectedComponents(mask);
  return Kept(parts, [&](std::int32_t number) {
    const auto voxels = parts.num_voxels[static_cast<std::size_t>(number)];
    return (static_cast<double>(voxels) * voxel_ml < kLeastPieceMl) == small;
  });
}

}  // namespace

void SmoothMuscles(const volume::CtVolume& ct, double fat_upper_hu, volume::LabelMap& labels) {
  const volume::Label muscle = volume::LabelOf("muscle"), fat = volume::LabelOf("fat"),
                      soft = volume::LabelOf("soft_tissue");
  const Mask whole = MaskOf(labels, muscle);
  if (Count(whole) == 0) return;
  Box box = BoundsOf(whole);
  const Eigen::Array3i margin = (3.0 / labels.geometry.spacing_mm).ceil().cast<int>() + 1;
  box.low = (box.low - margin).max(0);
  box.high = (box.high + margin).min(labels.geometry.size - 1);
  const volume::Grid<volume::Label> part = Cropped<volume::Label>(labels, box);
  Mask muscles = Cropped(whole, box);
  Mask gaps = muscles;
  for (std::size_t n = 0; n < gaps.voxels.size(); ++n) {
    const bool is_gap = part.voxels[n] == fat || part.voxels[n] == soft;
    const bool is_dent = is_gap && IsAmong(part, n, muscle);
    if (is_dent) muscles.voxels[n] = 1;
    gaps.voxels[n] = is_gap && !is_dent ? 1 : 0;
  }
  const double ml = labels.geometry.voxel_volume_mm3() / 1000.0;
  const Mask small_gaps = PartsBySize(gaps, true, ml);
  for (std::size_t n = 0; n < muscles.voxels.size(); ++n) {
    muscles.voxels[n] |= small_gaps.voxels[n];
  }
  const Mask after = PartsBySize(muscles, false, ml);
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
