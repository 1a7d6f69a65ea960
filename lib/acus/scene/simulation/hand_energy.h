// What the hand has put into a bent needle, and may get back.
#pragma once

#include <Eigen/Geometry>

#include "acus/physics/forces/models/needle_force.h"

namespace acus::simulation {

/// Of a bent needle, after a step.
struct BendingEnergy {
  double stored_n_mm = 0.0;
  /// Taken by cutting and friction in the last advance, which can pay for the bending that the
  /// advance does.
  double spent_n_mm = 0.0;
};

/// A plain value. The needle gives the hand no more than the hand has put in: by moving and turning
/// the hub, and by what an advance takes. Without this a hand could lean, advance and get the
/// difference for nothing, as the axial models do not know of the bending.
struct HandEnergy {
  double paid_n_mm = 0.0;
  double share = 1.0;  ///< Of the needle's force that the hand feels.
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();  ///< Of the device, in the last step.
  Eigen::Quaterniond ct_from_hand = Eigen::Quaterniond::Identity();

  /// Without work.
  void Follow(const Eigen::Vector3d& new_tip_in_ct_mm,
              const Eigen::Quaterniond& new_ct_from_hand) noexcept;

  /// @param before  What the hand felt across the path in the last step.
  /// @param across  The needle's force and torque on the hand; scaled to what may be given back.
  void Return(const Eigen::Vector3d& new_tip_in_ct_mm, const Eigen::Quaterniond& new_ct_from_hand,
              const BendingEnergy& needle, const forces::NeedleForce& before,
              forces::NeedleForce& across) noexcept;
};

}  // namespace acus::simulation
