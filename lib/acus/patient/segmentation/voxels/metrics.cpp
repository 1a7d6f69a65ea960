#include "acus/patient/segmentation/voxels/metrics.h"

#include <algorithm>

#include "acus/base/math/statistics.h"
#include "acus/patient/segmentation/voxels/crop.h"

namespace acus::segmentation {
namespace {

void RequireSameSize(const Mask& a, const Mask& b) {
  ACUS_REQUIRE((a.geometry.size == b.geometry.size).all(), "two segmentations to be compared have ",
               a.geometry.size.transpose(), " and ", b.geometry.size.transpose(), " voxels");
}

Mask SurfaceOf(const Mask& mask) {
  Mask surface(mask.geometry);
  const auto& size = mask.geometry.size;
  const auto outside = [&](int i, int j, int k) {
    return mask.geometry.Contains(i, j, k) && mask.At(i, j, k) == 0;
  };
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        if (mask.At(i, j, k) == 0) continue;
        surface.At(i, j, k) = outside(i - 1, j, k) || outside(i + 1, j, k) ||
                              outside(i, j - 1, k) || outside(i, j + 1, k) ||
                              outside(i, j, k - 1) || outside(i, j, k + 1);
      }
    }
  }
  return surface;
}

}  // namespace

double Dice(const Mask& a, const Mask& b) {
  RequireSameSize(a, b);
  std::size_t both = 0;
  std::size_t sum = 0;
  for (std::size_t i = 0; i < a.voxels.size(); ++i) {
    both += a.voxels[i] & b.voxels[i];
    sum += static_cast<std::size_t>(a.voxels[i]) + b.voxels[i];
  }
  return sum == 0 ? 1.0 : 2.0 * static_cast<double>(both) / static_cast<double>(sum);
}

double SurfaceDistance95Mm(const Mask& a, const Mask& b, int num_threads) {
  RequireSameSize(a, b);
  Mask surface_a = SurfaceOf(a);
  Mask surface_b = SurfaceOf(b);
  Box box = BoundsOf(surface_a);
  const Box other = BoundsOf(surface_b);
  ACUS_REQUIRE(!box.empty() && !other.empty(),
               "a segmentation is empty or fills the whole volume; "
               "it has no surface to measure distances to");
  box.low = box.low.min(other.low);
  box.high = box.high.max(other.high);
  // Distances far from either are not needed.
  surface_a = Cropped(surface_a, box);
  surface_b = Cropped(surface_b, box);
  std::vector<double> distances_mm;
  const auto collect = [&](const Mask& from, const Mask& to) {
    const volume::Grid<float> distance = DistanceMm(to, num_threads);
    for (std::size_t i = 0; i < from.voxels.size(); ++i) {
      if (from.voxels[i] != 0) distances_mm.push_back(distance.voxels[i]);
    }
  };
  collect(surface_a, surface_b);
  collect(surface_b, surface_a);
  return math::Quantile(distances_mm, 0.95);
}

}  // namespace acus::segmentation
