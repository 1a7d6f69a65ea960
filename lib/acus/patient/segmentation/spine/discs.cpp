#include <algorithm>
#include <cmath>
#include <vector>

#include "acus/patient/segmentation/spine/spine_parts.h"

namespace acus::segmentation {
namespace {

constexpr double kColumnHalfWidthMm = 27.0;
constexpr double kColumnDepthMm = 46.0;  ///< From the canal's centre to the front of the bodies.
constexpr double kThickestDiscMm = 16.0;
constexpr double kThinnestDiscMm = 2.0;
constexpr double kMostDiscHu = 160.0;
constexpr double kHeightBinMm = 1.0;
constexpr int kVoteReachBins = 3;
constexpr double kLeastShare = 0.33;      ///< Of the columns that meet bone.
constexpr double kLeastPitchMm = 17.0;    ///< Between discs.
constexpr double kMostOffPlaneMm = 6.0;   ///< Of the middle of a gap from its disc's plane.
constexpr double kTangentReachMm = 20.0;  ///< The canal's direction is taken over that height.

/// One gap between two runs of bone, along a line that runs beside the canal's centre.
struct Gap {
  int first = 0;  ///< Slices.
  int last = 0;
  Eigen::Vector2d from_centre_mm;
  double height_mm = 0.0;  ///< Of its middle, carried to the canal's centre square to the canal.
};

/// How far the canal's centre moves back per mm upwards, around slice k.
double Slope(const CanalTube& tube, int k, double step_mm) {
  const int reach = static_cast<int>(kTangentReachMm / step_mm);
  const int low = std::max(k - reach, tube.first);
  const int high = std::min(k + reach, tube.last());
  if (low == high) return 0.0;
  return (tube.Centre(high).y() - tube.Centre(low).y()) / ((high - low) * step_mm);
}

/// The voxel beside the canal's centre, or nothing beyond the border.
std::optional<std::size_t> VoxelBeside(const SpineView& view, int k,
                                       const Eigen::Vector2d& from_centre_mm) {
  const volume::Geometry& g = view.ct.geometry;
  const Eigen::Vector2d p = view.tube.Centre(k) + from_centre_mm;
  const int i = static_cast<int>(std::lround(p.x() / g.spacing_mm[0]));
  const int j = static_cast<int>(std::lround(p.y() / g.spacing_mm[1]));
  if (!g.Contains(i, j, k)) return std::nullopt;
  return g.Index(i, j, k);
}

/// Appends the gaps of one line; true if it meets bone.
bool AddGaps(const SpineView& view, const Eigen::Vector2d& from_centre_mm, double fat_upper_hu,
             std::vector<Gap>& gaps) {
  const double step_mm = view.ct.geometry.spacing_mm[2];
  int last_bone = -1;
  double sum_hu = 0.0;
  for (int k = view.tube.first; k <= view.tube.last(); ++k) {
    const auto at = VoxelBeside(view, k, from_centre_mm);
    if (!at) return last_bone >= 0;
    if (view.bone.voxels[*at] == 0) {
      sum_hu += view.ct.voxels[*at];
      continue;
    }
    const int count = k - last_bone - 1;
    const double thickness_mm = count * step_mm;
    if (last_bone >= 0 && thickness_mm >= kThinnestDiscMm && thickness_mm <= kThickestDiscMm &&
        sum_hu / count > fat_upper_hu && sum_hu / count < kMostDiscHu) {
      Gap gap{last_bone + 1, k - 1, from_centre_mm, 0.0};
      const int middle = (gap.first + gap.last) / 2;
      gap.height_mm = 0.5 * (gap.first + gap.last) * step_mm +
                      Slope(view.tube, middle, step_mm) * from_centre_mm.y();
      gaps.push_back(gap);
    }
    last_bone = k;
    sum_hu = 0.0;
  }
  return last_bone >= 0;
}

/// Heights at which enough lines have a gap.
std::vector<double> DiscHeightsMm(const std::vector<Gap>& gaps, double height_mm, int num_lines) {
  const int reach = kVoteReachBins;
  const int offset = 60;  // Gaps in front may lie beyond the ends.
  std::vector<int> votes(static_cast<std::size_t>(height_mm / kHeightBinMm) + 2 * offset + 1, 0);
  for (const Gap& gap : gaps) {
    const auto bin = static_cast<int>(std::lround(gap.height_mm / kHeightBinMm)) + offset;
    if (bin >= 0 && bin < static_cast<int>(votes.size())) ++votes[static_cast<std::size_t>(bin)];
  }
  std::vector<std::pair<int, int>> peaks;  // Votes, bin.
  for (int b = reach; b + reach < static_cast<int>(votes.size()); ++b) {
    int sum = 0;
    for (int d = -reach; d <= reach; ++d) sum += votes[static_cast<std::size_t>(b + d)];
    if (sum >= kLeastShare * num_lines) peaks.emplace_back(-sum, b);
  }
  std::ranges::sort(peaks);
  std::vector<double> heights;
  for (const auto& [votes_below, bin] : peaks) {
    const double at_mm = (bin - offset) * kHeightBinMm;
    if (std::ranges::all_of(heights,
                            [&](double h) { return std::abs(h - at_mm) >= kLeastPitchMm; })) {
      heights.push_back(at_mm);
    }
  }
  return heights;
}

}  // namespace

Mask FindDiscs(const SpineView& view, double fat_upper_hu) {
  const volume::Geometry& g = view.ct.geometry;
  std::vector<Gap> gaps;
  int num_lines = 0;
  // No wider than a voxel, so that no voxel is omitted between two lines.
  const double grid_mm = 0.9 * std::min(g.spacing_mm[0], g.spacing_mm[1]);
  for (double back = -kColumnDepthMm; back <= 0.0; back += grid_mm) {
    for (double across = -kColumnHalfWidthMm; across <= kColumnHalfWidthMm; across += grid_mm) {
      num_lines += AddGaps(view, {across, back}, fat_upper_hu, gaps) ? 1 : 0;
    }
  }
  const auto heights = DiscHeightsMm(gaps, (view.tube.last() + 1) * g.spacing_mm[2], num_lines);
  Mask discs(g);
  for (const Gap& gap : gaps) {
    if (std::ranges::none_of(
            heights, [&](double h) { return std::abs(gap.height_mm - h) <= kMostOffPlaneMm; })) {
      continue;
    }
    for (int k = gap.first; k <= gap.last; ++k) {
      const auto at = VoxelBeside(view, k, gap.from_centre_mm);
      if (at && view.canal.voxels[*at] == 0 && view.ct.voxels[*at] > fat_upper_hu)
        discs.voxels[*at] = 1;
    }
  }
  return discs;
}

}  // namespace acus::segmentation
