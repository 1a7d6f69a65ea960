// Binary volumes and what is done with them: distances, morphology by balls, components, holes.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// 1 = inside. All operations treat voxels beyond the border as outside, unless they say otherwise.
using Mask = volume::Grid<std::uint8_t>;

std::size_t Count(const Mask& mask);

/// Where this label is.
Mask MaskOf(const volume::Grid<volume::Label>& labels, volume::Label label);
/// Where any label but 0, outside, is.
Mask BodyOf(const volume::Grid<volume::Label>& labels);

/// Voxels within `radius_mm` of the mask (distance between voxel centres, in mm: the ball is round
/// also on uneven grids). Exact. Cost O(voxels * radius / spacing).
Mask Dilated(const Mask& mask, double radius_mm, int num_threads);

/// Voxels farther than `radius_mm` from any outside voxel. Beyond the border counts as inside, so
/// that a body that is cut by the border keeps its full cross-section there.
Mask Eroded(const Mask& mask, double radius_mm, int num_threads);

/// Closed = dilated, then eroded; opened = eroded, then dilated.
Mask Closed(const Mask& mask, double radius_mm, int num_threads);
Mask Opened(const Mask& mask, double radius_mm, int num_threads);

/// Connected components over voxel faces.
struct Components {
  volume::Grid<std::int32_t> number;    ///< 0 = outside the mask, otherwise 1 ... count.
  std::vector<std::size_t> num_voxels;  ///< By number; [0] is unused.
};
Components ConnectedComponents(const Mask& mask);

/// Removes the components for which `keep(number)` is false.
Mask Kept(const Components& components, const std::function<bool(std::int32_t)>& keep);

/// A region outside a mask, connected within one slice.
struct SliceRegion {
  std::vector<std::size_t> voxels;
  bool touches_border = false;  ///< Of the slice.
};

/// Adds to the mask those regions outside it, in every slice normal to `axis` (0 = i, 1 = j, 2 =
/// k), for which `accept` is true; without `accept`, all that do not touch the border of the slice.
void FillInSlices(Mask& mask, int axis, int num_threads,
                  const std::function<bool(const SliceRegion&)>& accept = {});

/// Exact Euclidean distance [mm] of every voxel centre to the nearest voxel of the mask
/// (Felzenszwalb & Huttenlocher 2012, separable lower envelopes). Infinite if the mask is empty.
volume::Grid<float> DistanceMm(const Mask& mask, int num_threads);

/// The box [low, high] of the mask, or an empty one (high < low).
struct Box {
  Eigen::Array3i low = Eigen::Array3i::Zero();
  Eigen::Array3i high = Eigen::Array3i::Constant(-1);
  bool empty() const { return (high < low).any(); }
};
Box BoundsOf(const Mask& mask);

}  // namespace acus::segmentation
