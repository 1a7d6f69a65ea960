#include "acus/physics/breathing/motion_map.h"

#include <Eigen/SVD>

namespace acus::breathing {

math::InversePoint MotionMap::RestOf(const Eigen::Vector3d& world_mm,
                                     const Eigen::Vector3d& start_mm,
                                     const math::InverseSettings& settings) const noexcept {
  if (!moves()) return {.rest_mm = world_mm};
  return math::InvertDisplacement(
      [this](const Eigen::Vector3d& rest_mm) { return DisplacementMm(rest_mm); }, world_mm,
      start_mm, settings);
}

Eigen::Matrix3d MotionMap::GradientAt(const Eigen::Vector3d& rest_mm) const noexcept {
  Eigen::Matrix3d gradient = Eigen::Matrix3d::Identity();
  if (!moves()) return gradient;
  constexpr double kHalfMm = 1.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = kHalfMm * Eigen::Vector3d::Unit(axis);
    gradient.col(axis) +=
        (DisplacementMm(rest_mm + step) - DisplacementMm(rest_mm - step)) / (2.0 * kHalfMm);
  }
  return gradient;
}

Eigen::Matrix3d RotationOf(const Eigen::Matrix3d& gradient) noexcept {
  if (!(gradient.determinant() > 0.0)) return Eigen::Matrix3d::Identity();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(gradient, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace acus::breathing
