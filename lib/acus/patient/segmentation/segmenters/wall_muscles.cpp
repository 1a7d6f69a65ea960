#include "acus/patient/segmentation/segmenters/wall_muscles.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "acus/base/core/parallel.h"
#include "acus/data/volume/labels.h"
#include "acus/patient/segmentation/segmenters/trunk_wall.h"
#include "acus/patient/segmentation/voxels/line_filter.h"
#include "acus/patient/segmentation/voxels/trilinear.h"

namespace acus::segmentation {
namespace {

using volume::Label;

constexpr double kHalfSheetMm = 2.5;  ///< Of the thickest sheet that is no muscle.
constexpr double kHalfGapMm = 1.5;    ///< Of the thickest layer of fat that counts as muscle.
constexpr double kLeastMuscleMl = 2.0;
constexpr double kHalfBackMm = 50.0;     ///< The back muscles reach 10 mm farther.
constexpr double kWallSmoothMm = 3.0;    ///< Takes the stairs of the coarse grid off the wall.
constexpr double kFractionInside = 0.5;  ///< At the inner surface of the wall.

/// How far inside the wall each voxel is: 1 inside, 0 outside, smooth between them.
volume::Grid<float> InsideOf(const TrunkWall& wall, int num_threads) {
  volume::Grid<float> share(wall.inside.geometry);
  std::ranges::copy(wall.inside.voxels, share.voxels.begin());
  return Blurred(share, kWallSmoothMm, num_threads);
}

/// Beside the spine, from its front to the back.
bool IsBack(const TrunkWall& wall, const Eigen::Vector3d& index) {
  const int last = static_cast<int>(wall.slices.size()) - 1;
  const int k = std::clamp(static_cast<int>(std::lround(index.z())), 0, last);
  const TrunkSlice& slice = wall.slices[static_cast<std::size_t>(k)];
  return std::abs(index.x() - slice.middle_x) * TrunkWall::kGridMm < kHalfBackMm &&
         index.y() > slice.spine_y;
}

/// All voxels between skin and cavity, but those of the back.
Mask WallZone(const volume::LabelMap& labels, const TrunkWall& wall, int num_threads) {
  const volume::Grid<float> inside = InsideOf(wall, num_threads);
  const Eigen::Affine3d coarse_from_index =
      wall.inside.geometry.index_from_ct() * labels.geometry.ct_from_index();
  Mask zone(labels.geometry);
  const Eigen::Array3i& size = labels.geometry.size;
  ParallelFor(size[2], num_threads, [&](int k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        if (labels.At(i, j, k) == 0) continue;
        const Eigen::Vector3d at = coarse_from_index * Eigen::Vector3d(i, j, k);
        zone.At(i, j, k) = TrilinearAt(inside, at) < kFractionInside && !IsBack(wall, at) ? 1 : 0;
      }
    }
  });
  return zone;
}

/// What is neither skin nor fat, and no thin sheet.
Mask Thick(const volume::LabelMap& labels, int num_threads) {
  const Label skin = volume::LabelOf("skin"), fat = volume::LabelOf("fat"),
              cut = volume::LabelOf("cut");
  Mask solid(labels.geometry);
  for (std::size_t n = 0; n < solid.voxels.size(); ++n) {
    const Label here = labels.voxels[n];
    solid.voxels[n] = here != 0 && here != skin && here != fat && here != cut ? 1 : 0;
  }
  return Opened(solid, kHalfSheetMm, num_threads);
}

/// Soft tissue of the wall, in parts that are large enough.
Mask SoftWall(const volume::LabelMap& labels, const Mask& zone, int num_threads) {
  const Label soft = volume::LabelOf("soft_tissue"), muscle = volume::LabelOf("muscle");
  Mask wall = Thick(labels, num_threads);
  for (std::size_t n = 0; n < wall.voxels.size(); ++n) {
    const Label here = labels.voxels[n];
    if (zone.voxels[n] == 0 || (here != soft && here != muscle)) wall.voxels[n] = 0;
  }
  const double ml = labels.geometry.voxel_volume_mm3() / 1000.0;
  const Components parts = ConnectedComponents(wall);
  return Kept(parts, [&](std::int32_t number) {
    return static_cast<double>(parts.num_voxels[static_cast<std::size_t>(number)]) * ml >
           kLeastMuscleMl;
  });
}

}  // namespace

void AddWallMuscles(volume::LabelMap& labels, int num_threads) {
  const std::optional<TrunkWall> wall = FindTrunkWall(labels, num_threads);
  if (!wall) return;
  const Label soft = volume::LabelOf("soft_tissue"), fat = volume::LabelOf("fat"),
              muscle = volume::LabelOf("muscle");
  const Mask zone = WallZone(labels, *wall, num_threads);
  const Mask found = SoftWall(labels, zone, num_threads);
  if (Count(found) == 0) return;
  const Mask closed = Closed(found, kHalfGapMm, num_threads);
  // The opening takes the outermost soft tissue off; a needle would pass it and miss the fascia.
  const Mask near = Dilated(found, kHalfSheetMm, num_threads);
  for (std::size_t n = 0; n < found.voxels.size(); ++n) {
    const Label here = labels.voxels[n];
    const bool is_gap = closed.voxels[n] != 0 && (here == fat || here == soft);
    const bool is_rim = near.voxels[n] != 0 && here == soft;
    const bool fills = zone.voxels[n] != 0 && (is_gap || is_rim);
    if (found.voxels[n] != 0 || fills) labels.voxels[n] = muscle;
  }
  labels.names[muscle] = "muscle";
}

}  // namespace acus::segmentation
