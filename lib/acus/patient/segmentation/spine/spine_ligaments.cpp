#include <algorithm>
#include <cmath>
#include <vector>

#include "acus/patient/segmentation/spine/spine_parts.h"

namespace acus::segmentation {
namespace {

constexpr double kFlavumMm = 4.4;  ///< Thickness from front to back.
constexpr double kFlavumHalfWidthMm = 15.0;
constexpr double kMostFatBehindMm = 8.0;  ///< Between the canal's tube and the flavum.
constexpr double kFatToLigamentHu = -15.0;
constexpr double kThinnestFlavumMm = 1.5;  ///< Less before bone is the blur of the bone.
constexpr double kInterspinousHalfMm = 2.2;
constexpr double kSupraspinousHalfMm = 4.0;
constexpr double kSupraspinousMm = 4.5;
constexpr double kTipHalfWidthMm = 3.0;
constexpr double kTipFromMm = 22.0;  ///< Behind the canal's centre.
constexpr double kTipToMm = 75.0;
constexpr double kTipReachMm = 20.0;  ///< From one spinous process to the next.

struct SlicePlace {
  const SpineView& view;
  int k;

  int Column(double across_mm) const {
    return static_cast<int>(
        std::lround((view.tube.Centre(k).x() + across_mm) / view.ct.geometry.spacing_mm[0]));
  }
  int Row(double back_mm) const {
    return static_cast<int>(
        std::lround((view.tube.Centre(k).y() + back_mm) / view.ct.geometry.spacing_mm[1]));
  }
};

/// Mean over 3 x 3 voxels across and along the spine: sharp from front to back.
double SheetHu(const volume::CtVolume& ct, int i, int j, int k) {
  const volume::Geometry& g = ct.geometry;
  double sum = 0.0;
  int count = 0;
  for (int c = std::max(k - 1, 0); c <= std::min(k + 1, g.size[2] - 1); ++c) {
    for (int a = std::max(i - 1, 0); a <= std::min(i + 1, g.size[0] - 1); ++a) {
      sum += ct.At(a, j, c);
      ++count;
    }
  }
  return sum / count;
}

/// Last row of the canal in column i, or -1.
int CanalBack(const SpineView& view, int i, int k) {
  const auto& size = view.ct.geometry.size;
  if (i < 0 || i >= size[0]) return -1;
  for (int j = size[1] - 1; j >= 0; --j) {
    if (view.canal.At(i, j, k) != 0) return j;
  }
  return -1;
}

/// First row of the flavum behind the canal in column i, or -1.
int FlavumFront(const SpineView& view, int i, int k) {
  const volume::Geometry& g = view.ct.geometry;
  const auto& size = g.size;
  const int back = CanalBack(view, i, k);
  if (back < 0) return -1;
  const int reach = static_cast<int>(kMostFatBehindMm / g.spacing_mm[1]);
  const int thin = static_cast<int>(std::ceil(kThinnestFlavumMm / g.spacing_mm[1]));
  for (int j = back + 1; j <= std::min(back + reach, size[1] - 1 - thin); ++j) {
    if (SheetHu(view.ct, i, j, k) < kFatToLigamentHu) continue;
    for (int ahead = 0; ahead < thin; ++ahead) {
      if (view.bone.At(i, j + ahead, k) != 0) return -1;
    }
    return j;
  }
  return -1;
}

/// The median of the fronts of columns and slices next to it, or -1 where most have none.
int SmoothedFront(const std::vector<std::vector<int>>& fronts, std::size_t slice,
                  std::size_t column) {
  std::vector<int> near;
  int none = 0;
  for (std::size_t s = slice - std::min<std::size_t>(slice, 1);
       s <= std::min(slice + 1, fronts.size() - 1); ++s) {
    for (std::size_t c = column - std::min<std::size_t>(column, 1);
         c <= std::min(column + 1, fronts[s].size() - 1); ++c) {
      const int front = fronts[s][c];
      if (front < 0) {
        ++none;
      } else {
        near.push_back(front);
      }
    }
  }
  if (near.empty() || fronts[slice][column] < 0) return -1;
  const auto middle = near.begin() + static_cast<std::ptrdiff_t>(near.size() / 2);
  std::ranges::nth_element(near, middle);
  return *middle;
}

/// How far behind the canal's centre the spinous processes end, by slice; 0 where none is near.
std::vector<double> TipsMm(const SpineView& view) {
  const volume::Geometry& g = view.ct.geometry;
  std::vector<double> tips;
  for (int k = view.tube.first; k <= view.tube.last(); ++k) {
    const SlicePlace place{view, k};
    double tip = 0.0;
    for (double back = kTipFromMm; back <= kTipToMm; back += g.spacing_mm[1]) {
      for (double across = -kTipHalfWidthMm; across <= kTipHalfWidthMm; across += g.spacing_mm[0]) {
        const int i = place.Column(across);
        const int j = place.Row(back);
        if (g.Contains(i, j, k) && view.bone.At(i, j, k) != 0) tip = back;
      }
    }
    tips.push_back(tip);
  }
  const int reach = static_cast<int>(kTipReachMm / g.spacing_mm[2]);
  std::vector<double> line(tips.size(), 0.0);
  for (int k = 0; k < static_cast<int>(tips.size()); ++k) {
    const int low = std::max(k - reach, 0);
    const int high = std::min(k + reach, static_cast<int>(tips.size()) - 1);
    line[static_cast<std::size_t>(k)] =
        *std::max_element(tips.begin() + low, tips.begin() + high + 1);
  }
  return line;
}

/// Sets the soft voxels that are neither bone nor canal, from row j0 to row j1 of a column.
void SetSoft(const SpineView& view, int i, int j0, int j1, int k, double fat_upper_hu,
             Mask& ligament) {
  for (int j = j0; j <= j1; ++j) {
    if (!view.ct.geometry.Contains(i, j, k) || view.bone.At(i, j, k) != 0 ||
        view.canal.At(i, j, k) != 0 || view.ct.At(i, j, k) <= fat_upper_hu) {
      continue;
    }
    ligament.At(i, j, k) = 1;
  }
}

/// All fronts of the flavum: by slice of the tube, then by column from -half width.
std::vector<std::vector<int>> FlavumFronts(const SpineView& view) {
  const int half = static_cast<int>(kFlavumHalfWidthMm / view.ct.geometry.spacing_mm[0]);
  std::vector<std::vector<int>> fronts;
  for (int k = view.tube.first; k <= view.tube.last(); ++k) {
    const SlicePlace place{view, k};
    auto& row = fronts.emplace_back();
    for (int c = -half; c <= half; ++c) row.push_back(FlavumFront(view, place.Column(0.0) + c, k));
  }
  return fronts;
}

}  // namespace

Mask FindSpineLigaments(const SpineView& view, double fat_upper_hu) {
  const volume::Geometry& g = view.ct.geometry;
  Mask ligament(g);
  const auto fronts = FlavumFronts(view);
  const std::vector<double> tips = TipsMm(view);
  const int thick = static_cast<int>(std::lround(kFlavumMm / g.spacing_mm[1]));
  for (std::size_t s = 0; s < fronts.size(); ++s) {
    const int k = view.tube.first + static_cast<int>(s);
    const SlicePlace place{view, k};
    const int half = static_cast<int>(fronts[s].size() / 2);
    for (int c = -half; c <= half; ++c) {
      const int front = SmoothedFront(fronts, s, static_cast<std::size_t>(c + half));
      const int i = place.Column(0.0) + c;
      if (front >= 0) SetSoft(view, i, front, front + thick - 1, k, fat_upper_hu, ligament);
      const int back = CanalBack(view, i, k);
      if (std::abs(c) * g.spacing_mm[0] > kInterspinousHalfMm || tips[s] <= 0.0 || back < 0)
        continue;
      const int start = front >= 0 ? front : back + 1 + thick;
      SetSoft(view, i, start, place.Row(tips[s]), k, fat_upper_hu, ligament);
    }
    if (tips[s] <= 0.0) continue;
    for (double across = -kSupraspinousHalfMm; across <= kSupraspinousHalfMm;
         across += g.spacing_mm[0]) {
      SetSoft(view, place.Column(across), place.Row(tips[s]), place.Row(tips[s] + kSupraspinousMm),
              k, fat_upper_hu, ligament);
    }
  }
  return ligament;
}

}  // namespace acus::segmentation
