#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/patient/segmentation/spine/spinal_canal.h"

namespace acus::segmentation {
namespace {

constexpr double kLeastCanalMm2 = 90.0;
constexpr double kMostCanalMm2 = 800.0;
constexpr double kLeastCanalHu = -120.0;  ///< Epidural fat alone.
constexpr double kMostCanalHu = 120.0;    ///< Marrow of adults is denser, or has no body in front.
constexpr double kLeastRoundness = 0.45;  ///< Area over that of the ellipse with the same extent.
constexpr double kLeastStepToBodyHu = 40.0;
constexpr double kLeastBodyHu = 75.0;     ///< Above muscle.
constexpr double kLeastBodyShare = 0.45;  ///< Of the box in front; the wall of a long bone is less.
constexpr double kBodyFromMm = 3.0;       ///< In front of the hole.
constexpr double kBodyToMm = 20.0;
constexpr double kBodyHalfWidthMm = 9.0;
constexpr double kMostFromMiddleMm = 55.0;
constexpr double kMiddleReachMm = 60.0;
constexpr double kMiddleWidthMm = 35.0;  ///< A hole so far beside the middle counts for a third.
constexpr double kShortestChainMm = 14.0;
constexpr double kLongestGapMm = 60.0;
constexpr double kGapCost = 0.15;   ///< Of a gap, per mm, against 1 for each mm of holes.
constexpr double kShiftCost = 0.5;  ///< Of what a step goes beyond the free shift, per mm.

/// Extent of a hole: what the tests need of its voxels.
struct HoleExtent {
  double left_mm = std::numeric_limits<double>::infinity();
  double right_mm = -std::numeric_limits<double>::infinity();
  double front_mm = std::numeric_limits<double>::infinity();
  double back_mm = -std::numeric_limits<double>::infinity();
  double mean_hu = 0.0;
};

/// Share of the box in front of a hole that is denser than `least_hu`; 0 where it leaves the slice.
double DenseShareInFront(const volume::CtVolume& ct, int k, double u_mm, double front_mm,
                         double least_hu) {
  const volume::Geometry& g = ct.geometry;
  const auto index = [&](double mm, int axis) {
    return static_cast<int>(std::lround(mm / g.spacing_mm[axis]));
  };
  const int i0 = index(u_mm - kBodyHalfWidthMm, 0);
  const int i1 = index(u_mm + kBodyHalfWidthMm, 0);
  const int j0 = index(front_mm - kBodyToMm, 1);
  const int j1 = index(front_mm - kBodyFromMm, 1);
  if (!g.Contains(i0, j0, k) || !g.Contains(i1, j1, k)) return 0.0;
  int dense = 0;
  for (int j = j0; j <= j1; ++j) {
    for (int i = i0; i <= i1; ++i) dense += ct.At(i, j, k) > least_hu ? 1 : 0;
  }
  return static_cast<double>(dense) / ((i1 - i0 + 1) * (j1 - j0 + 1));
}

/// The median of the bone across (along u), by slice, from all slices within kMiddleReachMm.
std::vector<double> MiddlesMm(const Mask& bone) {
  const volume::Geometry& g = bone.geometry;
  std::vector<std::vector<double>> count(static_cast<std::size_t>(g.size[2]));
  for (int k = 0; k < g.size[2]; ++k) {
    auto& here = count[static_cast<std::size_t>(k)];
    here.assign(static_cast<std::size_t>(g.size[0]), 0.0);
    for (int j = 0; j < g.size[1]; ++j) {
      for (int i = 0; i < g.size[0]; ++i) here[static_cast<std::size_t>(i)] += bone.At(i, j, k);
    }
  }
  const int reach = static_cast<int>(kMiddleReachMm / g.spacing_mm[2]);
  std::vector<double> middles;
  for (int k = 0; k < g.size[2]; ++k) {
    std::vector<double> column(static_cast<std::size_t>(g.size[0]), 0.0);
    double total = 0.0;
    for (int near = std::max(k - reach, 0); near <= std::min(k + reach, g.size[2] - 1); ++near) {
      for (std::size_t i = 0; i < column.size(); ++i) {
        column[i] += count[static_cast<std::size_t>(near)][i];
        total += count[static_cast<std::size_t>(near)][i];
      }
    }
    std::size_t i = 0;
    for (double sum = column[0]; 2.0 * sum < total; sum += column[i]) ++i;
    middles.push_back(static_cast<double>(i) * g.spacing_mm[0]);
  }
  return middles;
}

/// Appends the region to `found` if it looks like a canal.
void AddIfCanal(const volume::CtVolume& ct, const SliceRegion& region, double middle_mm,
                std::vector<CanalHole>& found) {
  const volume::Geometry& g = ct.geometry;
  const double pixel_mm2 = g.spacing_mm[0] * g.spacing_mm[1];
  CanalHole hole;
  hole.area_mm2 = static_cast<double>(region.voxels.size()) * pixel_mm2;
  if (region.touches_border || hole.area_mm2 < kLeastCanalMm2 || hole.area_mm2 > kMostCanalMm2)
    return;
  const auto row = static_cast<std::size_t>(g.size[0]);
  const std::size_t slice = g.Index(0, 0, 1);
  hole.k = static_cast<int>(region.voxels.front() / slice);
  HoleExtent extent;
  for (const std::size_t at : region.voxels) {
    const Eigen::Vector2d p(static_cast<double>(at % row) * g.spacing_mm[0],
                            static_cast<double>(at % slice / row) * g.spacing_mm[1]);
    hole.centre_mm += p;
    extent.left_mm = std::min(extent.left_mm, p.x());
    extent.right_mm = std::max(extent.right_mm, p.x());
    extent.front_mm = std::min(extent.front_mm, p.y());
    extent.back_mm = std::max(extent.back_mm, p.y());
    extent.mean_hu += ct.voxels[at];
  }
  hole.centre_mm /= static_cast<double>(region.voxels.size());
  extent.mean_hu /= static_cast<double>(region.voxels.size());
  hole.from_middle_mm = std::abs(hole.centre_mm.x() - middle_mm);
  if (hole.from_middle_mm > kMostFromMiddleMm) return;
  if (extent.mean_hu < kLeastCanalHu || extent.mean_hu > kMostCanalHu) return;
  const double ellipse_mm2 = 0.25 * M_PI * (extent.right_mm - extent.left_mm + g.spacing_mm[0]) *
                             (extent.back_mm - extent.front_mm + g.spacing_mm[1]);
  if (hole.area_mm2 < kLeastRoundness * ellipse_mm2) return;
  const double least_hu = std::max(extent.mean_hu + kLeastStepToBodyHu, kLeastBodyHu);
  if (DenseShareInFront(ct, hole.k, hole.centre_mm.x(), extent.front_mm, least_hu) <
      kLeastBodyShare) {
    return;
  }
  found.push_back(hole);
}

}  // namespace

std::vector<CanalHole> FindCanalHoles(const volume::CtVolume& ct, const Mask& shell,
                                      int num_threads) {
  std::vector<std::vector<CanalHole>> by_slice(static_cast<std::size_t>(ct.geometry.size[2]));
  Mask rings = shell;
  const std::vector<double> middles_mm = MiddlesMm(shell);
  const std::size_t slice = ct.geometry.Index(0, 0, 1);
  FillInSlices(rings, 2, num_threads, [&](const SliceRegion& region) {
    const std::size_t k = region.voxels.front() / slice;
    AddIfCanal(ct, region, middles_mm[k], by_slice[k]);
    return false;
  });
  std::vector<CanalHole> holes;
  for (const auto& found : by_slice) holes.insert(holes.end(), found.begin(), found.end());
  return holes;
}

std::vector<CanalHole> CanalChain(const std::vector<CanalHole>& holes, const volume::Geometry& g) {
  const double step_mm = g.spacing_mm[2];
  std::vector<double> worth_mm;
  for (const CanalHole& hole : holes) {
    const double beside = hole.from_middle_mm / kMiddleWidthMm;
    worth_mm.push_back(step_mm * std::exp(-beside * beside));
  }
  std::vector<double> score = worth_mm;
  std::vector<std::ptrdiff_t> before(holes.size(), -1);
  for (std::size_t b = 0; b < holes.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const double dz_mm = (holes[b].k - holes[a].k) * step_mm;
      if (dz_mm <= 0.0 || dz_mm > kLongestGapMm) continue;
      const Eigen::Vector2d shift = (holes[b].centre_mm - holes[a].centre_mm).cwiseAbs();
      const double beyond_mm = std::max(0.0, shift.x() - 2.0 - 0.25 * dz_mm) +
                               std::max(0.0, shift.y() - 2.0 - 0.7 * dz_mm);
      const double with_a =
          score[a] + worth_mm[b] - kGapCost * (dz_mm - step_mm) - kShiftCost * beyond_mm;
      if (beyond_mm > 10.0 || with_a <= score[b]) continue;
      score[b] = with_a;
      before[b] = static_cast<std::ptrdiff_t>(a);
    }
  }
  std::vector<CanalHole> chain;
  if (holes.empty()) return chain;
  auto at = std::ranges::max_element(score) - score.begin();
  for (; at >= 0; at = before[static_cast<std::size_t>(at)])
    chain.push_back(holes[static_cast<std::size_t>(at)]);
  std::ranges::reverse(chain);
  if (static_cast<double>(chain.size()) * step_mm < kShortestChainMm) chain.clear();
  return chain;
}

}  // namespace acus::segmentation
