// Many points of a patient at one moment of breath: MotionMap for lattices.
#pragma once

#include <Eigen/Core>

#include "acus/physics/breathing/motion_map.h"

namespace acus::breathing {

/// displacement_mm.col(n) = u(rest_mm.col(n)), CT space, in single precision: within 1e-5 of what
/// MotionMap::DisplacementMm says and 1e-4 mm. Fastest where points that follow each other are
/// near each other. The same bits on every machine; allocates nothing. The two may be the same.
/// @pre motion.moves(), and the same number of columns.
void DisplacementsMm(const MotionMap& motion, Eigen::Ref<const Eigen::Matrix3Xf> rest_mm,
                     Eigen::Ref<Eigen::Matrix3Xf> displacement_mm) noexcept;

}  // namespace acus::breathing
