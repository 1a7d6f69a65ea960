#include "acus/rig/haptics/axes.h"

#include <sstream>

#include "acus/base/core/error.h"

namespace acus::haptics {
namespace {

/// Farther from a rotation than this is no rounding: something is broken.
constexpr double kMostSkew = 0.05;

}  // namespace

Axes::Axes(const std::string& device_from_vendor, const std::string& label) {
  std::istringstream words(device_from_vendor);
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  std::string word;
  int row = 0;
  bool is_good = true;
  for (; words >> word; ++row) {
    const std::size_t column = word.size() == 2 ? std::string("xyz").find(word[1]) : 3;
    is_good = is_good && row < 3 && column < 3 && (word[0] == '+' || word[0] == '-');
    if (is_good) matrix(row, static_cast<Eigen::Index>(column)) = word[0] == '+' ? 1.0 : -1.0;
  }
  is_good = is_good && row == 3 && matrix.determinant() > 0.5;
  ACUS_REQUIRE(is_good, label, ": axes are '", device_from_vendor,
               "'; they must name the vendor's axes that are right, up and to the user, such as ",
               "'+x +y +z' or '+y +z +x', each once and not mirrored");
  matrix_ = matrix;
}

Eigen::Isometry3d Axes::ToDevice(const Eigen::Matrix3d& rotation,
                                 const Eigen::Vector3d& place_mm) const noexcept {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = matrix_ * place_mm;
  Eigen::Matrix3d turned = rotation;
  const Eigen::Matrix3d skew = rotation.transpose() * rotation - Eigen::Matrix3d::Identity();
  // Not so for what is not finite, either.
  if (skew.cwiseAbs().maxCoeff() <= kMostSkew && rotation.determinant() > 0.0) {
    turned = Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
  }
  pose.linear() = matrix_ * turned * matrix_.transpose();
  return pose;
}

}  // namespace acus::haptics
