#include "acus/data/transforms/pose.h"

#include <cmath>

#include "acus/base/core/error.h"

namespace acus::transforms {
namespace {

// A normalised quaternion has a squared norm of 1 to within about 8 ulp. Normalising it once more
// could move its last bits, and a file that is read and written again would drift.
constexpr double kUnitTolerance = 4e-15;

}  // namespace

Pose::Pose(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& translation_mm)
    : quaternion_(rotation) {
  const double squared_norm = rotation.squaredNorm();
  ACUS_ASSERT(squared_norm > 0.0);
  if (std::abs(squared_norm - 1.0) > kUnitTolerance) quaternion_.normalize();
  isometry_.linear() = quaternion_.toRotationMatrix();
  isometry_.translation() = translation_mm;
}

}  // namespace acus::transforms
