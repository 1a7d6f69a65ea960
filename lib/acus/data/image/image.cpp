#include "acus/data/image/image.h"

namespace acus::image {

Eigen::Affine3d ImageGeometry::probe_from_image() const {
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  out.linear() =
      Eigen::Vector3d(lateral_mm_per_px, axial_mm_per_px, lateral_mm_per_px).asDiagonal();
  out.translation() << -0.5 * (width_px - 1) * lateral_mm_per_px, depth_of_top_row_mm, 0.0;
  return out;
}

}  // namespace acus::image
