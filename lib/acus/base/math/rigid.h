// Rigid transforms, named target_from_source: x_target = target_from_source * x_source. Lengths mm.
#pragma once

#include <Eigen/Geometry>

namespace acus::math {

/// True if all entries are finite and the linear part is a rotation to within `tolerance`
/// (largest entry of R^T R - I; determinant positive).
bool IsRigid(const Eigen::Matrix4d& matrix, double tolerance = 1e-3);

/// The rigid transform nearest to `matrix` (rotation by SVD), for matrices that were rounded in a
/// file. @throws InputError if IsRigid(matrix, tolerance) does not hold.
Eigen::Isometry3d RigidFromMatrix(const Eigen::Matrix4d& matrix, double tolerance = 1e-3);

/// Translation linear, rotation along the shorter great arc. fraction 0 gives a, 1 gives b.
Eigen::Isometry3d Interpolate(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                              double fraction);

/// Angle of the rotation between two poses, in [0, pi].
double AngleBetweenRad(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// A pose at `origin_mm` whose +z is along `z_axis` and whose +x is as near to `x_hint` as can be.
/// @pre z_axis is not zero. If x_hint is parallel to z_axis, any perpendicular is taken.
Eigen::Isometry3d PoseFromAxes(const Eigen::Vector3d& origin_mm, const Eigen::Vector3d& z_axis,
                               const Eigen::Vector3d& x_hint);

/// Swaps the patient frames LPS and RAS: diag(-1, -1, 1). Its own inverse.
Eigen::Isometry3d RasFromLps(const Eigen::Isometry3d& lps_from_source_lps);

}  // namespace acus::math
