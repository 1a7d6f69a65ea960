#include "acus/patient/atlas/organ_place.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "acus/base/core/parallel.h"
#include "acus/patient/segmentation/segmenters/tissues.h"

namespace acus::atlas {
namespace {

using segmentation::Mask;
using volume::Grid;

constexpr double kLeastShare = 0.1;  // Of an organ, that a part must have to be shifted.
constexpr double kShellFromMm = 3.0, kShellToMm = 9.0;
constexpr double kSpreadHu = 18.0;  // Of an organ, noise included.
constexpr double kFarCost = 0.03;   // Of the farthest shift along the body, in units of likeness.

/// 1 where HU are the organ's, falling to 0.
Grid<float> LikenessOf(const Grid<float>& hu, double organ_hu) {
  Grid<float> likeness(hu.geometry);
  for (std::size_t n = 0; n < hu.voxels.size(); ++n) {
    const double z = (hu.voxels[n] - organ_hu) / kSpreadHu;
    likeness.voxels[n] = static_cast<float>(std::exp(-0.5 * z * z));
  }
  return likeness;
}

using Voxels = std::vector<Eigen::Array3i>;

Voxels VoxelsOf(const Mask& mask) {
  Voxels out;
  const Eigen::Array3i& size = mask.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        if (mask.At(i, j, k) != 0) out.emplace_back(i, j, k);
      }
    }
  }
  return out;
}

/// Over those that lie in the volume after the shift; not a number if that is less than half.
double MeanAt(const Grid<float>& grid, const Voxels& voxels, const Eigen::Array3i& shift) {
  double sum = 0.0;
  std::size_t count = 0;
  for (const Eigen::Array3i& voxel : voxels) {
    const Eigen::Array3i at = voxel + shift;
    if (!grid.geometry.Contains(at[0], at[1], at[2])) continue;
    sum += grid.At(at[0], at[1], at[2]);
    ++count;
  }
  if (2 * count < voxels.size()) return std::numeric_limits<double>::quiet_NaN();
  return sum / static_cast<double>(count);
}

struct Scored {
  double score = -std::numeric_limits<double>::infinity();
  Eigen::Array3i shift = Eigen::Array3i::Zero();
};

/// The best shift of a part, in voxels; of equal ones the first.
Eigen::Array3i BestShift(const Grid<float>& likeness, const Mask& part, double along_mm,
                         int num_threads) {
  const double spacing_mm = part.geometry.spacing_mm[0];
  const Grid<float> away_mm = segmentation::DistanceMm(part, num_threads);
  Mask shell(part.geometry);
  std::ranges::transform(away_mm.voxels, shell.voxels.begin(),
                         [](double mm) { return mm > kShellFromMm && mm <= kShellToMm ? 1 : 0; });
  const Voxels inside = VoxelsOf(part);
  const Voxels around = VoxelsOf(shell);
  const int along = static_cast<int>(along_mm / spacing_mm);
  const int axis = segmentation::AxialAxis(part.geometry);
  Eigen::Array3i reach = Eigen::Array3i::Constant(along / 2);
  reach[axis] = along;
  std::vector<Scored> best(static_cast<std::size_t>(2 * reach[2] + 1));
  ParallelFor(2 * reach[2] + 1, num_threads, [&](int plane) {
    Scored& here = best[static_cast<std::size_t>(plane)];
    for (int j = -reach[1]; j <= reach[1]; ++j) {
      for (int i = -reach[0]; i <= reach[0]; ++i) {
        const Eigen::Array3i shift(i, j, plane - reach[2]);
        const double far = spacing_mm * shift.cast<double>().matrix().norm() / along_mm;
        const double score = MeanAt(likeness, inside, shift) - MeanAt(likeness, around, shift) -
                             kFarCost * far * far;
        if (score > here.score) here = {.score = score, .shift = shift};
      }
    }
  });
  return std::ranges::max_element(best, {}, &Scored::score)->shift;
}

}  // namespace

Mask Placed(const Grid<float>& hu, const Mask& region, double organ_hu, double along_mm,
            int num_threads) {
  const segmentation::Components parts = segmentation::ConnectedComponents(region);
  const Grid<float> likeness = LikenessOf(hu, organ_hu);
  const auto all = static_cast<double>(segmentation::Count(region));
  Mask out(region.geometry);
  for (std::size_t number = 1; number < parts.num_voxels.size(); ++number) {
    const Mask part = segmentation::Kept(
        parts, [&](std::int32_t one) { return one == static_cast<std::int32_t>(number); });
    Eigen::Array3i shift = Eigen::Array3i::Zero();
    if (static_cast<double>(parts.num_voxels[number]) >= kLeastShare * all) {
      shift = BestShift(likeness, part, along_mm, num_threads);
    }
    for (const Eigen::Array3i& voxel : VoxelsOf(part)) {
      const Eigen::Array3i at = voxel + shift;
      if (out.geometry.Contains(at[0], at[1], at[2])) out.At(at[0], at[1], at[2]) = 1;
    }
  }
  return out;
}

}  // namespace acus::atlas
