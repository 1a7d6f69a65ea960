// Where the tools are at one moment: what every tissue model steps on.
#pragma once

#include <Eigen/Geometry>

namespace acus::tissue {

/// A plain value. What is wrong with a sample (not a number, time not later than before, lost
/// tracking) is dealt with by the model's Step, as forces::NeedleForceModel::Step does.
struct ToolSample {
  double time_s = 0.0;

  bool needle_valid = true;  ///< False: the tracker lost the needle.
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();  ///< Insertion direction; any length > 0.
  /// Where the tip of a needle that bends goes next, unit length; zero: along the axis. Read by
  /// SpringModel, whose path then bends, too.
  Eigen::Vector3d tip_direction_in_ct = Eigen::Vector3d::Zero();

  bool probe_valid = false;  ///< False: no probe in the scene, or the tracker lost it.
  /// Probe frame: origin at the middle of the face, +x to the marked side, +y into the body.
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();
};

}  // namespace acus::tissue
