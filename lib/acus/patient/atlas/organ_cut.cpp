#include "acus/patient/atlas/organ_cut.h"

#include <algorithm>
#include <cmath>

#include "acus/patient/atlas/hu_density.h"
#include "acus/patient/atlas/minimal_cut.h"

namespace acus::atlas {
namespace {

using segmentation::Mask;
using volume::Grid;

constexpr double kPriorWidthMm = 12.0;  // Distance from the prior's surface that counts as 1.
constexpr double kPriorWeight = 2.0, kLeastPrior = -3.0, kMostPrior = 2.0;
constexpr double kMostEvidence = 3.0;  // Of one voxel's HU: logarithm of the odds.
constexpr double kSurfaceCost = 3.0;   // Where HU are even; 0.15 of that at edges.
constexpr double kEdgeHu = 25.0;       // Per voxel.
constexpr double kForbidden = -20.0;
constexpr int kCutIterations = 150;
constexpr double kLeastSpreadHu = 14.0, kMostSpreadHu = 25.0;
constexpr double kSeenShare = 0.3;  // Of the model of HU that comes from the prior's inner part.
constexpr double kShellMm = 30.0, kGapMm = 3.0;  // Around the prior, whose HU are not the organ's.
constexpr double kLeastPart = 0.1;               // Of an organ: smaller parts are dropped.
constexpr int kBlurHu = 8;                       // Of histograms.

/// Logarithm of the odds that a voxel's HU are the organ's.
Grid<float> Evidence(const OrganSearch& search, double organ_hu) {
  const std::vector<float>& hu = search.hu.voxels;
  const float deepest = *std::ranges::max_element(search.prior_mm.voxels);
  const float margin_mm = std::min(6.0F, 0.3F * deepest);
  HuDensity inside(kBlurHu, 0.2), around(kBlurHu, 0.5);
  std::vector<double> deviations;
  for (std::size_t n = 0; n < hu.size(); ++n) {
    const double prior_mm = search.prior_mm.voxels[n];
    if (prior_mm > margin_mm && search.allowed.voxels[n] != 0 && hu[n] > -20.0F) {
      inside.Add(hu[n]);
      const double deviation = std::abs(hu[n] - organ_hu);
      if (deviation < 60.0) deviations.push_back(deviation);
    }
    if (prior_mm < -kGapMm && prior_mm > -kShellMm) around.Add(hu[n]);
  }
  inside.Normalise();
  around.Normalise();
  double spread_hu = kMostSpreadHu;
  if (!deviations.empty()) {
    const auto middle = deviations.begin() + static_cast<std::ptrdiff_t>(deviations.size() / 2);
    std::ranges::nth_element(deviations, middle);
    spread_hu = std::clamp(1.48 * *middle, kLeastSpreadHu, kMostSpreadHu);
  }
  Grid<float> evidence(search.hu.geometry);
  for (std::size_t n = 0; n < hu.size(); ++n) {
    const double z = (hu[n] - organ_hu) / spread_hu;
    // Three in a hundred voxels of an organ are something else: a vessel, a cyst, a stone.
    const double normal = 0.97 * std::exp(-0.5 * z * z) / (spread_hu * 2.5066) + 0.03 / 300.0;
    const double organ = (1.0 - kSeenShare) * normal + kSeenShare * inside.At(hu[n]);
    evidence.voxels[n] = static_cast<float>(
        std::clamp(std::log(organ / around.At(hu[n])), -kMostEvidence, kMostEvidence));
  }
  return evidence;
}

/// What the organ's surface costs: less where HU change.
Grid<float> SurfaceCost(const Grid<float>& hu) {
  const Eigen::Array3i& size = hu.geometry.size;
  Grid<float> cost(hu.geometry);
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const auto slope = [&](int di, int dj, int dk) {
          return 0.5F * (hu.At(std::min(i + di, size[0] - 1), std::min(j + dj, size[1] - 1),
                               std::min(k + dk, size[2] - 1)) -
                         hu.At(std::max(i - di, 0), std::max(j - dj, 0), std::max(k - dk, 0)));
        };
        const Eigen::Vector3f gradient(slope(1, 0, 0), slope(0, 1, 0), slope(0, 0, 1));
        const double edge = std::exp(-gradient.squaredNorm() / (kEdgeHu * kEdgeHu));
        cost.At(i, j, k) = static_cast<float>(kSurfaceCost * (0.15 + 0.85 * edge));
      }
    }
  }
  return cost;
}

/// u without parts that are small or lie wholly outside the prior.
void DropStrayParts(const OrganSearch& search, Grid<float>& u) {
  Mask region(u.geometry);
  for (std::size_t n = 0; n < u.voxels.size(); ++n) region.voxels[n] = u.voxels[n] > 0.5F;
  const segmentation::Components parts = segmentation::ConnectedComponents(region);
  std::vector<std::uint8_t> meets(parts.num_voxels.size(), 0);
  std::size_t all = 0;
  for (std::size_t n = 0; n < u.voxels.size(); ++n) {
    if (search.prior_mm.voxels[n] > 0.0F) {
      meets[static_cast<std::size_t>(parts.number.voxels[n])] = 1;
    }
    all += region.voxels[n];
  }
  for (std::size_t n = 0; n < u.voxels.size(); ++n) {
    const auto part = static_cast<std::size_t>(parts.number.voxels[n]);
    if (part == 0) continue;
    const bool small =
        static_cast<double>(parts.num_voxels[part]) < kLeastPart * static_cast<double>(all);
    if (small || meets[part] == 0) u.voxels[n] = 0.0F;
  }
}

}  // namespace

Grid<float> CutOrgan(const OrganSearch& search, double organ_hu, int num_threads) {
  Grid<float> preference = Evidence(search, organ_hu);
  for (std::size_t n = 0; n < preference.voxels.size(); ++n) {
    const double prior =
        std::clamp(search.prior_mm.voxels[n] / kPriorWidthMm, kLeastPrior, kMostPrior);
    preference.voxels[n] += static_cast<float>(kPriorWeight * prior);
    if (search.allowed.voxels[n] == 0) preference.voxels[n] = kForbidden;
  }
  Grid<float> u = MinimalCut(preference, SurfaceCost(search.hu), kCutIterations, num_threads);
  DropStrayParts(search, u);
  return u;
}

}  // namespace acus::atlas
