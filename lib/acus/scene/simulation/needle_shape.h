// The stage of the needle's shape: straight, on its path, or bent; and the force across the path.
//
// It comes after the force model, takes its forces along the path as they are and puts its own
// across the path in place of the model's. See docs/models/needle_shape.md.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>

#include "acus/base/math/polyline.h"
#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/path/needle_sample.h"
#include "acus/physics/forces/path/sample_gate.h"
#include "acus/physics/mechanics/elements/elasticity_table.h"
#include "acus/physics/needle/bendable_needle.h"
#include "acus/scene/scenario/needle_effect.h"
#include "acus/scene/simulation/hand_energy.h"

namespace acus::simulation {

/// Where the force model has the needle, after its step. The path is a straight line.
struct PathLine {
  bool pierced = false;
  Eigen::Vector3d entry_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_in_ct = Eigen::Vector3d::UnitZ();  ///< Unit length, into the body.
};

struct NeedleShapeInput {
  double time_s = 0.0;
  bool valid = false;  ///< False: the tracker lost the needle.
  Eigen::Isometry3d ct_from_needle = Eigen::Isometry3d::Identity();  ///< As the hand holds it.
  volume::Label tissue_at_tip = 0;
  /// Null: the model knows no line (deformed tissue); one is then kept from the puncture on.
  const PathLine* path = nullptr;
  bool pierced = false;  ///< Read if there is no line.
  /// Null: tissue does not move by itself. Only a bendable needle asks.
  const needle::PathMotion* motion = nullptr;
};

/// The same for the log.
struct NeedleShape {
  bool bent = false;                                       ///< In the body and bendable.
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();  ///< At the last usable sample.
  double tip_deflection_mm = 0.0;  ///< From the line along which the hub points.
};

/// A value: copy it to save, assign it to restore. Made by NeedleShapeModel::NewState.
struct NeedleShapeState {
  forces::SampleGate gate;  ///< Holds the force and torque across the path.
  PathLine line;            ///< At the last sample that was stepped on.
  double depth_mm = 0.0;
  needle::BendableNeedleState needle;  ///< Empty but for the model bendable.
  NeedleShape shape;
  Eigen::Vector3d tip_direction_in_ct = Eigen::Vector3d::Zero();  ///< Zero: along the needle.
  /// From the device's tip to the bent one, across the device's axis.
  Eigen::Vector3d tip_offset_mm = Eigen::Vector3d::Zero();
  HandEnergy hand;
};

/// Const after construction: any number of states may step side by side.
class NeedleShapeModel {
 public:
  /// @param table  its settings are read: limits, lost tracking, tissue across the path.
  /// @param elasticity  of the scene's tissues; null unless the model is bendable.
  /// @param tissues  labels that the scene has; those that can be deformed need elastic constants.
  /// @param force_has_beam  the force model has the beam across its path already.
  /// @throws InputError if a setting is out of range or a tissue has no elastic constants.
  NeedleShapeModel(const scenario::NeedleEffect& effect, const needle::NeedleProperties& needle,
                   const forces::ForceTable& table, const mechanics::ElasticityTable* elasticity,
                   const std::bitset<256>& tissues, bool force_has_beam);

  NeedleShapeState NewState() const;

  /// Moves and bends the needle, and replaces what `force` has across the path. Bad samples as
  /// forces::NeedleForceModel::Step; the sum keeps the table's largest_force_n. Allocates nothing.
  void Step(NeedleShapeState& state, const NeedleShapeInput& input,
            forces::NeedleForce& force) const noexcept;

  /// From the tip to the hub, in CT space. False, and `out` untouched, if the needle is straight
  /// where the hand holds it.
  bool ShapeOf(const NeedleShapeState& state, math::Polyline& out) const noexcept;

  /// Once punctured: the axis that the needle is held to; else `axis_in_ct`.
  const Eigen::Vector3d& LockedAxis(const NeedleShapeState& state,
                                    const Eigen::Vector3d& axis_in_ct) const noexcept {
    return axis_lock_ && state.line.pierced ? state.line.direction_in_ct : axis_in_ct;
  }

  /// True if there is nothing to do for a needle that is not in the body.
  bool IsAsleep(const NeedleShapeState& state) const noexcept { return !state.line.pierced; }

  const std::optional<needle::BendableNeedle>& bendable() const { return bendable_; }
  /// Of the tissue across a shaft, N/mm per mm of it, by label.
  double StiffnessNPerMm2(volume::Label tissue) const { return stiffness_n_per_mm2_[tissue]; }

 private:
  void Follow(NeedleShapeState& state, const NeedleShapeInput& input,
              double depth_mm) const noexcept;
  forces::NeedleForce Beam(const NeedleShapeState& state,
                           const Eigen::Vector3d& tip_in_ct_mm) const noexcept;
  forces::NeedleForce Bend(NeedleShapeState& state, const NeedleShapeInput& input,
                           const forces::NeedleForce& along) const noexcept;

  scenario::NeedleModelKind model_;
  bool axis_lock_;
  bool keeps_force_;  ///< lateral_beam, and the force model has it.
  needle::NeedleProperties needle_;
  forces::ForceSettings settings_;
  std::optional<needle::BendableNeedle> bendable_;
  std::array<double, 256> stiffness_n_per_mm2_{};
};

}  // namespace acus::simulation
