// A rigid pose as files hold it, so that writing and reading gives the same bits.
#pragma once

#include <Eigen/Geometry>

namespace acus::transforms {

/// A rigid pose, target_from_source, kept as a unit quaternion and a translation in mm. The matrix
/// is always the one that belongs to the quaternion: a pose that is made live and the same pose
/// read from its recording agree in every bit. Assigning a matrix goes through the quaternion,
/// which moves its entries by about 1e-16.
class Pose {
 public:
  Pose() = default;
  /// @pre the linear part is a rotation to within rounding. (Implicit: a Pose is an Isometry3d.)
  Pose(const Eigen::Isometry3d& target_from_source)  // NOLINT(google-explicit-constructor)
      : Pose(Eigen::Quaterniond(target_from_source.linear()), target_from_source.translation()) {}
  /// Normalises the quaternion, unless its norm is 1 to within rounding. @pre it is not zero.
  Pose(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation_mm);

  const Eigen::Isometry3d& isometry() const { return isometry_; }
  operator const Eigen::Isometry3d&() const { return isometry_; }  // NOLINT: see above.
  const Eigen::Quaterniond& quaternion() const { return quaternion_; }

  const Eigen::Matrix4d& matrix() const { return isometry_.matrix(); }
  auto linear() const { return isometry_.linear(); }
  auto translation() const { return isometry_.translation(); }  ///< mm.
  Eigen::Isometry3d inverse() const { return isometry_.inverse(); }

  Eigen::Vector3d operator*(const Eigen::Vector3d& point_mm) const { return isometry_ * point_mm; }
  Eigen::Isometry3d operator*(const Eigen::Isometry3d& source_from_other) const {
    return isometry_ * source_from_other;
  }
  Eigen::Isometry3d operator*(const Pose& source_from_other) const {
    return isometry_ * source_from_other.isometry_;
  }
  friend Eigen::Isometry3d operator*(const Eigen::Isometry3d& other_from_target, const Pose& pose) {
    return other_from_target * pose.isometry_;
  }

  /// Equal in every entry.
  bool operator==(const Pose& other) const {
    return isometry_.matrix() == other.isometry_.matrix();
  }

 private:
  Eigen::Quaterniond quaternion_ = Eigen::Quaterniond::Identity();
  Eigen::Isometry3d isometry_ = Eigen::Isometry3d::Identity();
};

}  // namespace acus::transforms
