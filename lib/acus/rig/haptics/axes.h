// From a vendor's axes to the device frame: x right, y up, z to the user.
#pragma once

#include <Eigen/Geometry>
#include <string>

namespace acus::haptics {

/// Which vendor's axis each axis of the device frame is: "+y +z +x" for Force Dimension, whose x is
/// to the user, y right and z up.
class Axes {
 public:
  Axes() = default;
  /// @throws InputError unless it names each axis once, with a sign, and mirrors nothing; `label`
  ///     begins the message.
  Axes(const std::string& device_from_vendor, const std::string& label);

  const Eigen::Matrix3d& device_from_vendor() const noexcept { return matrix_; }

  Eigen::Vector3d ToDevice(const Eigen::Vector3d& v) const noexcept { return matrix_ * v; }
  Eigen::Vector3d ToVendor(const Eigen::Vector3d& v) const noexcept {
    return matrix_.transpose() * v;
  }
  /// The rotation is made orthonormal (SDKs are off by about 1e-3), unless it is no rotation at
  /// all: then it stays, and the guard refuses it. The handle's own axes are turned, too: it lies
  /// along the device frame where the vendor says that it is not turned.
  Eigen::Isometry3d ToDevice(const Eigen::Matrix3d& rotation,
                             const Eigen::Vector3d& place_mm) const noexcept;

 private:
  Eigen::Matrix3d matrix_ = Eigen::Matrix3d::Identity();
};

}  // namespace acus::haptics
