#include "acus/physics/breathing/moved_points.h"

#include "acus/base/core/error.h"
#include "acus/physics/breathing/field_now.h"

namespace acus::breathing {

void DisplacementsMm(const MotionMap& motion, Eigen::Ref<const Eigen::Matrix3Xf> rest_mm,
                     Eigen::Ref<Eigen::Matrix3Xf> displacement_mm) noexcept {
  ACUS_ASSERT(motion.moves() && rest_mm.cols() == displacement_mm.cols());
  kernels::Displacements(FieldOf(motion), rest_mm.data(), static_cast<int>(rest_mm.cols()),
                         displacement_mm.data());
}

}  // namespace acus::breathing
