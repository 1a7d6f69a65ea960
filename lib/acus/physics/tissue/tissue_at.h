// Which tissue is where, for models that have no mesh.
#pragma once

#include <Eigen/Core>
#include <functional>

#include "acus/data/volume/volume.h"

namespace acus::tissue {

/// Label of the tissue at rest at a place of CT space; 0 outside the body. Must not throw, allocate
/// or lock: it is called in the step.
using TissueAt = std::function<volume::Label(const Eigen::Vector3d& rest_in_ct_mm)>;

/// HU of the CT at such a place; the same rules.
using HuAt = std::function<double(const Eigen::Vector3d& rest_in_ct_mm)>;

}  // namespace acus::tissue
