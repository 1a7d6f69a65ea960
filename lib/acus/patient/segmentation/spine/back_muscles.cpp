#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "acus/patient/segmentation/spine/spine_parts.h"

namespace acus::segmentation {
namespace {

constexpr double kBackHalfWidthMm = 60.0;
constexpr double kFromBackMm = -7.0;   ///< The back wall of the bodies, from the canal's centre.
constexpr double kBoneToMm = 60.0;     ///< Transverse processes and ribs lie in front of that.
constexpr double kBoneReachMm = 14.0;  ///< Along the spine, from one process to the next.
constexpr double kBesideBone = 0.6;  ///< How far the wall recedes beyond the last bone, mm per mm.
constexpr double kNoBone = std::numeric_limits<double>::infinity();

/// How far behind the canal's centre the first bone lies, by column across from -kBackHalfWidthMm.
using Wall = std::vector<double>;

int NumColumns(const volume::Geometry& g) {
  return 2 * static_cast<int>(kBackHalfWidthMm / g.spacing_mm[0]) + 1;
}

Wall BoneIn(const SpineView& view, int k) {
  const volume::Geometry& g = view.ct.geometry;
  const int count = NumColumns(g);
  Wall wall(static_cast<std::size_t>(count), kNoBone);
  const Eigen::Vector2d centre = view.tube.Centre(k);
  const int middle = static_cast<int>(std::lround(centre.x() / g.spacing_mm[0]));
  for (int c = 0; c < count; ++c) {
    const int i = middle + c - count / 2;
    for (double back = kFromBackMm; back < kBoneToMm; back += g.spacing_mm[1]) {
      const int j = static_cast<int>(std::lround((centre.y() + back) / g.spacing_mm[1]));
      if (!g.Contains(i, j, k) || view.bone.At(i, j, k) == 0) continue;
      wall[static_cast<std::size_t>(c)] = back;
      break;
    }
  }
  return wall;
}

/// Between columns with bone the wall is straight; beyond the last it recedes.
void Close(Wall& wall, double column_mm) {
  const int count = static_cast<int>(wall.size());
  const int middle = count / 2;
  wall[static_cast<std::size_t>(middle)] = kFromBackMm;
  for (const int side : {-1, 1}) {
    int last = middle;
    for (int c = middle; c >= 0 && c < count; c += side) {
      const auto at = static_cast<std::size_t>(c);
      if (wall[at] == kNoBone) continue;
      const double from = wall[static_cast<std::size_t>(last)];
      for (int between = last + side; between != c && last != c; between += side) {
        const double part = static_cast<double>(between - last) / (c - last);
        wall[static_cast<std::size_t>(between)] = from + part * (wall[at] - from);
      }
      last = c;
    }
    for (int c = last + side; c >= 0 && c < count; c += side) {
      wall[static_cast<std::size_t>(c)] =
          wall[static_cast<std::size_t>(c - side)] + kBesideBone * column_mm;
    }
  }
}

}  // namespace

Mask FindBackMuscles(const SpineView& view, const Mask& body, double fat_upper_hu) {
  const volume::Geometry& g = view.ct.geometry;
  Mask muscle(g);
  std::vector<Wall> bone;
  for (int k = view.tube.first; k <= view.tube.last(); ++k) bone.push_back(BoneIn(view, k));
  const int reach = static_cast<int>(kBoneReachMm / g.spacing_mm[2]);
  const int count = NumColumns(g);
  for (int k = view.tube.first; k <= view.tube.last(); ++k) {
    Wall wall(static_cast<std::size_t>(count), kNoBone);
    for (int near = std::max(k - reach, view.tube.first);
         near <= std::min(k + reach, view.tube.last()); ++near) {
      const Wall& there = bone[static_cast<std::size_t>(near - view.tube.first)];
      for (std::size_t c = 0; c < wall.size(); ++c) wall[c] = std::min(wall[c], there[c]);
    }
    Close(wall, g.spacing_mm[0]);
    const Eigen::Vector2d centre = view.tube.Centre(k);
    const int middle = static_cast<int>(std::lround(centre.x() / g.spacing_mm[0]));
    for (int c = 0; c < count; ++c) {
      const int i = middle + c - count / 2;
      for (int j = 0; j < g.size[1]; ++j) {
        if (!g.Contains(i, j, k) ||
            j * g.spacing_mm[1] < centre.y() + wall[static_cast<std::size_t>(c)]) {
          continue;
        }
        const std::size_t at = g.Index(i, j, k);
        muscle.voxels[at] = body.voxels[at] != 0 && view.ct.voxels[at] > fat_upper_hu ? 1 : 0;
      }
    }
  }
  return muscle;
}

}  // namespace acus::segmentation
