#include <cmath>

#include "acus/patient/segmentation/spine_parts.h"

namespace acus::segmentation {
namespace {

constexpr double kHalfWidthMm = 60.0;
constexpr double kFromBackMm = -7.0;  ///< The back wall of the bodies, from the canal's centre.

}  // namespace

Mask FindBackMuscles(const SpineView& view, const Mask& body, double fat_upper_hu) {
  const volume::Geometry& g = view.ct.geometry;
  Mask muscle(g);
  for (int k = view.tube.first; k <= view.tube.last(); ++k) {
    const Eigen::Vector2d centre = view.tube.Centre(k);
    for (int j = 0; j < g.size[1]; ++j) {
      if (j * g.spacing_mm[1] < centre.y() + kFromBackMm) continue;
      for (int i = 0; i < g.size[0]; ++i) {
        if (std::abs(i * g.spacing_mm[0] - centre.x()) > kHalfWidthMm) continue;
        const std::size_t at = g.Index(i, j, k);
        muscle.voxels[at] = body.voxels[at] != 0 && view.ct.voxels[at] > fat_upper_hu ? 1 : 0;
      }
    }
  }
  return muscle;
}

}  // namespace acus::segmentation
