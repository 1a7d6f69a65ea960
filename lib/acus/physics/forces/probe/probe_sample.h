// What every model of the force on a probe or a fingertip takes in and gives out.
#pragma once

#include <Eigen/Geometry>

#include "acus/data/volume/volume.h"

namespace acus::forces {

struct ProbeInput {
  double time_s = 0.0;
  Eigen::Isometry3d ct_from_probe = Eigen::Isometry3d::Identity();  ///< Origin: middle of the face.
  bool valid = true;
};

struct ProbeForce {
  Eigen::Vector3d force_in_ct_n = Eigen::Vector3d::Zero();  ///< On the probe.
  bool on_skin = false;
  bool on_bone = false;
  double skin_mm =
      0.0;  ///< From the device back to the proxy on the skin; the farthest of several.
  double bone_mm = 0.0;  ///< To the proxy on bone.
  /// On the probe, about the middle of its face; zero in models with one proxy.
  Eigen::Vector3d torque_in_ct_n_mm = Eigen::Vector3d::Zero();
  int num_on_skin = 0;  ///< Proxies.
  volume::Label structure =
      0;  ///< The structure under the skin that presses most, the strongest of several; 0: none.
};

}  // namespace acus::forces
