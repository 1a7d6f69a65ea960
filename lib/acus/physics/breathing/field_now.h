// A MotionMap as the kernels read it.
#pragma once

#include "acus/physics/breathing/displacement_kernel.h"
#include "acus/physics/breathing/motion_map.h"

namespace acus::breathing {

/// Valid as long as the map's field.
kernels::FieldNow FieldOf(const MotionMap& motion);

}  // namespace acus::breathing
