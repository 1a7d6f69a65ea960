// A bendable needle in a hand and in tissue, step by step: the shape part of algorithm 1 of
// Fortmeier-2016. How far the tip cuts in a step is for the force models to say; this follows.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "acus/physics/needle/path_coupling.h"
#include "acus/physics/needle/rod.h"

namespace acus::needle {

struct BendableNeedleOptions {
  RodOptions rod;
  double path_spacing_mm = 1.0;
  CouplingOptions coupling;
  HandSpring hand;
  double kappa_n_per_mm = 0.5;  ///< Eq. 8: between the hub and the hand.
  /// The spring of eq. 8 pulls the hub, too, and the torque is the slope of the needle's energy by
  /// the hand's turn: the hand then gets back what it put in. False, as in the paper: it pulls the
  /// hand only, and the torque is that of a spring from its axis to the needle at the skin.
  bool hand_has_potential = false;
  BevelTip bevel;  ///< Curvature 0: the tip goes where it points.
};

/// Where the hand is, and what the tip did.
struct BendableNeedleInput {
  Eigen::Vector3d tip_mm = Eigen::Vector3d::Zero();          ///< Of the needle if it were not bent.
  Eigen::Quaterniond hand = Eigen::Quaterniond::Identity();  ///< +z along the needle, to its tip.
  bool touches = false;  ///< That tip is in the body: begins a path if there is none.
  /// Travel of the tip in the tissue since the last step; < 0 back. In the step that begins a path,
  /// how far behind tip_mm the skin is.
  double advance_mm = 0.0;
  PathNode tissue;                     ///< At the tip: label and stiffness.
  const PathMotion* motion = nullptr;  ///< Null: tissue stays where the path was cut.
};

/// A value: copy it to save, assign it to restore.
struct BendableNeedleState {
  RodState rod;
  CurvedPath path;
  Eigen::Vector3d heading = Eigen::Vector3d::UnitZ();  ///< Of a bevel tip's path.
  std::vector<RodContact> contacts;                    ///< Of the last step.
  int num_contacts = 0;
};

struct BendableNeedleStep {
  RodResult rod;
  Eigen::Vector3d hand_force_n = Eigen::Vector3d::Zero();  ///< Eq. 8.
  /// On the hand. With hand_has_potential: about tip_mm.
  Eigen::Vector3d hand_torque_n_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d tip_direction = Eigen::Vector3d::UnitZ();  ///< Where the next advance goes.
};

class BendableNeedle {
 public:
  /// @throws InputError as RodModel does, or if a spacing or stiffness is not positive.
  BendableNeedle(const RodProperties& properties, const BendableNeedleOptions& options);

  BendableNeedleState NewState() const;

  /// Moves the path's tip, couples and solves. In air the needle is straight in the hand and there
  /// is no force. Allocates nothing. Input that is not finite is refused as by RodModel::Solve and
  /// leaves path and shape as they were.
  BendableNeedleStep Step(BendableNeedleState& state,
                          const BendableNeedleInput& input) const noexcept;

  const RodModel& rod() const { return rod_; }
  const BendableNeedleOptions& options() const { return options_; }

 private:
  void MovePath(BendableNeedleState& state, const BendableNeedleInput& input) const noexcept;
  struct Entry {
    Eigen::Vector3d position_mm;
    Eigen::Vector3d direction;  ///< Of the path there, unit.
  };
  Entry EntryNow(const BendableNeedleState& state, const BendableNeedleInput& input) const noexcept;
  RodInput InHand(const BendableNeedleState& state,
                  const BendableNeedleInput& input) const noexcept;
  void HandOf(const BendableNeedleState& state, const BendableNeedleInput& input,
              BendableNeedleStep& step) const noexcept;

  RodModel rod_;
  BendableNeedleOptions options_;
};

}  // namespace acus::needle
