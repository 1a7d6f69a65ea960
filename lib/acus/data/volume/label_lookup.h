// The label at a place of a label map.
#pragma once

#include <Eigen/Geometry>

#include "acus/data/volume/volume.h"

namespace acus::volume {

/// The label of the nearest voxel; 0 outside the volume, and for a point that is not finite.
/// Allocates nothing.
/// @param index_from_space  From the point's space to voxel indices, such as
///     Geometry::index_from_ct() for points in CT space.
Label LabelAt(const LabelMap& labels, const Eigen::Affine3d& index_from_space,
              const Eigen::Vector3d& point_mm) noexcept;

}  // namespace acus::volume
