// What tools do to the tissue at one moment: all that an image needs to show it deformed.
#pragma once

#include <Eigen/Core>
#include <array>

#include "acus/physics/tissue/plane_frame.h"

namespace acus::tissue {

/// A force on the tissue at a place of the tissue at rest.
struct PointLoad {
  Eigen::Vector3d rest_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_in_ct_n = Eigen::Vector3d::Zero();
};

/// The needle in the tissue, for models that compute displacements from forces along it only.
struct NeedleLoad {
  bool in_contact = false;  ///< The tip touches or is inside the body.
  bool pierced = false;     ///< The skin has yielded.
  Eigen::Vector3d entry_in_ct_mm =
      Eigen::Vector3d::Zero();                             ///< Where it touched the skin, at rest.
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();  ///< Where the tip is.
  Eigen::Vector3d axis_in_ct = Eigen::Vector3d::UnitZ();   ///< Unit length, into the body.
  double pre_puncture_n = 0.0;  ///< Axial force while a membrane is pressed in; >= 0.
  double cutting_n = 0.0;       ///< At the tip, after puncture; >= 0.
  double friction_n = 0.0;      ///< Along the shaft; + pushes the tissue inwards.
};

/// A plain value of fixed size: taking one in a step allocates nothing.
struct TissueLoad {
  static constexpr int kMaxPoints = 800;
  std::array<PointLoad, kMaxPoints> point{};
  int num_points = 0;
  NeedleLoad needle;
  PlaneFrame plane;  ///< Of PlaneModel2010.
};

}  // namespace acus::tissue
