// Which ribs lie under the skin around a point, seen from outside.
#pragma once

#include <array>

#include "acus/patient/phantom/anatomy/patient_field.h"

namespace acus::phantom {

/// Bone and cartilage within 45 mm under the skin, on a square of 80 mm around a point.
class RibShadow {
 public:
  RibShadow(const PatientField& field, const Eigen::Vector3d& point_ct_mm,
            const Eigen::Vector3d& skin_normal);

  /// Bone on both sides of the point, across the ribs, within 36 mm, and none under it.
  bool IsBetweenRibs() const;

  /// Along the ribs, in the tangent plane; unit, CT frame. That in which bone, summed along lines,
  /// is sharpest. Any direction if there is no bone.
  Eigen::Vector3d rib_direction() const;

 private:
  static constexpr int kHalf = 13;  ///< Points to either side.
  static constexpr int kSize = 2 * kHalf + 1;
  static constexpr double kStepMm = 3.0;
  bool At(double u_mm, double v_mm) const;
  double Sharpness(double angle_rad) const;

  std::array<bool, kSize * kSize> bone_{};
  Eigen::Vector3d u_, v_;
  double rib_angle_rad_ = 0.0;
};

}  // namespace acus::phantom
