// The initial pose of the probe in a virtual hand.
#pragma once

#include <Eigen/Geometry>

#include "acus/run/training/structures.h"

namespace acus::live {

/// The probe moved along its beam onto the skin, pressed in by 1 mm. Unchanged if no tissue lies
/// within 150 mm in front of its face, or the face lies in tissue already.
Eigen::Isometry3d OnSkin(const Eigen::Isometry3d& reference_from_probe,
                         const training::LabelAtPoint& label_at);

}  // namespace acus::live
