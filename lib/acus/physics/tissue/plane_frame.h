// Where a plane of tissue lies in CT space.
#pragma once

#include <Eigen/Core>

namespace acus::tissue {

/// A plain value. Plane coordinates (x, y) are along the first two columns, from the origin, mm.
struct PlaneFrame {
  Eigen::Vector3d origin_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Matrix3d ct_from_plane = Eigen::Matrix3d::Identity();  ///< Across, axis, normal.
  int tissue = 0;  ///< Which of the model's elastic planes is meant.

  Eigen::Vector3d ToPlaneMm(const Eigen::Vector3d& ct_mm) const {  ///< x, y, off the plane.
    return ct_from_plane.transpose() * (ct_mm - origin_in_ct_mm);
  }
  Eigen::Vector3d DirectionInPlane(const Eigen::Vector3d& in_ct) const {
    return ct_from_plane.transpose() * in_ct;
  }
  Eigen::Vector3d ToCtMm(const Eigen::Vector2d& plane_mm) const {
    return origin_in_ct_mm + DirectionInCt(plane_mm);
  }
  Eigen::Vector3d DirectionInCt(const Eigen::Vector2d& plane) const {  ///< Of a vector.
    return ct_from_plane.leftCols<2>() * plane;
  }
};

}  // namespace acus::tissue
