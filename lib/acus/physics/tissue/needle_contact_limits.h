// What the sources of the needle contact share. Private to this module.
#pragma once

#include <Eigen/Geometry>

namespace acus::tissue {

inline constexpr double kRigidMpa = 1e3;      ///< Of tissue whose nodes are all held still.
inline constexpr double kTurnCosine = 0.966;  ///< Beyond 15 degrees the frame follows the needle.
inline constexpr double kLeastCosine = 0.5;   ///< Beyond 60 degrees in one step contact is lost.
inline constexpr double kOutsideMm = 1.0;     ///< Certainly off the skin that it just left.

inline Eigen::Matrix3d FrameAlong(const Eigen::Vector3d& axis) {
  Eigen::Matrix3d frame;
  const Eigen::Vector3d first = axis.unitOrthogonal();
  frame << first, axis.cross(first), axis;
  return frame;
}

}  // namespace acus::tissue
