#include <algorithm>
#include <limits>

#include "acus/base/core/parallel.h"
#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::segmentation {
namespace {

constexpr double kSoftBesideBoneHu = 50.0;
constexpr double kDeepestTrimMm = 2.5;  ///< A closed gap is at most twice as wide.

/// Whether the voxel lies on the far side of the edge: below half of the height from soft tissue
/// to the densest neighbour.
bool IsBeyondEdge(const volume::CtVolume& ct, const Mask& bone, int i, int j, int k) {
  const volume::Geometry& g = ct.geometry;
  int peak = -1024;
  for (int c = std::max(k - 1, 0); c <= std::min(k + 1, g.size[2] - 1); ++c) {
    for (int b = std::max(j - 1, 0); b <= std::min(j + 1, g.size[1] - 1); ++b) {
      for (int a = std::max(i - 1, 0); a <= std::min(i + 1, g.size[0] - 1); ++a) {
        if (bone.At(a, b, c) != 0) peak = std::max<int>(peak, ct.At(a, b, c));
      }
    }
  }
  return ct.At(i, j, k) < 0.5 * (peak + kSoftBesideBoneHu);
}

/// Beyond the border of the volume counts as bone: what is cut there has no edge.
bool IsOutermost(const Mask& bone, int i, int j, int k) {
  const auto is_out = [&](int a, int b, int c) {
    return bone.geometry.Contains(a, b, c) && bone.At(a, b, c) == 0;
  };
  return is_out(i - 1, j, k) || is_out(i + 1, j, k) || is_out(i, j - 1, k) || is_out(i, j + 1, k) ||
         is_out(i, j, k - 1) || is_out(i, j, k + 1);
}

}  // namespace

Mask TrimmedToEdge(const volume::CtVolume& ct, const Mask& bone, const BoneFound& found,
                   int num_threads) {
  const volume::Geometry& g = ct.geometry;
  Mask trimmed = bone;
  const int passes = static_cast<int>(kDeepestTrimMm / g.spacing_mm.minCoeff());
  // A coarser voxel is wider than blur and gaps.
  if (passes < 2) return trimmed;
  // The blur of dense voxels is one voxel wide; what is below the threshold was a gap that closed.
  const double infinity = std::numeric_limits<double>::infinity();
  for (int pass = found.enhanced ? 1 : 0; pass < passes; ++pass) {
    const double most_hu = pass == 0 ? infinity : found.threshold_hu;
    const Mask before = trimmed;
    ParallelFor(g.size[2], num_threads, [&](int k) {
      for (int j = 0; j < g.size[1]; ++j) {
        for (int i = 0; i < g.size[0]; ++i) {
          if (before.At(i, j, k) != 0 && ct.At(i, j, k) <= most_hu &&
              IsOutermost(before, i, j, k) && IsBeyondEdge(ct, before, i, j, k)) {
            trimmed.At(i, j, k) = 0;
          }
        }
      }
    });
  }
  return trimmed;
}

}  // namespace acus::segmentation
