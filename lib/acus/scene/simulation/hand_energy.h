// The work of the hand on a bent needle, which limits the energy that it gives back.
#pragma once

#include <Eigen/Geometry>

#include "acus/physics/forces/models/needle_force.h"

namespace acus::simulation {

/// Energies of a bent needle after a step.
struct BendingEnergy {
  double stored_n_mm = 0.0;
  /// Dissipated by cutting and friction in the last advance; this work can pay for the bending that
  /// the advance causes.
  double spent_n_mm = 0.0;
};

/// Makes the bent needle passive: it returns no more energy than the hand has put in by moving and
/// turning the hub, and by the work of an advance. Without this a hand could lean, advance and gain
/// the difference, as the axial models do not contain the bending. A plain value.
struct HandEnergy {
  double paid_n_mm = 0.0;
  double share = 1.0;  ///< Share of the needle's force that reaches the hand.
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();  ///< Tip of the device in the last step.
  Eigen::Quaterniond ct_from_hand = Eigen::Quaterniond::Identity();

  /// Takes over the pose without counting work.
  void Follow(const Eigen::Vector3d& new_tip_in_ct_mm,
              const Eigen::Quaterniond& new_ct_from_hand) noexcept;

  /// @param before  Force and torque on the hand across the path in the last step.
  /// @param across  The needle's force and torque on the hand; scaled to the energy that remains.
  void Return(const Eigen::Vector3d& new_tip_in_ct_mm, const Eigen::Quaterniond& new_ct_from_hand,
              const BendingEnergy& needle, const forces::NeedleForce& before,
              forces::NeedleForce& across) noexcept;
};

}  // namespace acus::simulation
