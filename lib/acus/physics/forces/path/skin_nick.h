// A cut in the skin for the needle, made before the insertion: no skin is punctured there.
#pragma once

#include <Eigen/Core>

namespace acus::forces {

struct SkinNick {
  Eigen::Vector3d at_in_ct_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;  ///< 0: there is none.

  bool Contains(const Eigen::Vector3d& point_in_ct_mm) const noexcept {
    return (point_in_ct_mm - at_in_ct_mm).squaredNorm() < radius_mm * radius_mm;
  }
};

}  // namespace acus::forces
