// The stage of the needle's shape: straight, on its path, or bent; and the force across the path.
//
// It runs after the force model, keeps its forces along the path and replaces those across the
// path. See docs/models/needle_shape.md.
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

/// The path in the force model, after its step: a straight line.
struct PathLine {
  bool pierced = false;
  Eigen::Vector3d entry_in_ct_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_in_ct = Eigen::Vector3d::UnitZ();  ///< Unit length, into the body.
};

struct NeedleShapeInput {
  double time_s = 0.0;
  bool valid = false;  ///< False: the tracker does not see the needle.
  Eigen::Isometry3d ct_from_needle = Eigen::Isometry3d::Identity();  ///< Pose in the hand.
  volume::Label tissue_at_tip = 0;
  /// Null: the model has no line (deformed tissue); that of the puncture is then kept.
  const PathLine* path = nullptr;
  bool pierced = false;  ///< Read if there is no line.
  /// Null: tissue does not move by itself. Only a bendable needle reads it.
  const needle::PathMotion* motion = nullptr;
};

/// The shape in the log.
struct NeedleShape {
  bool bent = false;                                       ///< In the body and bendable.
  Eigen::Vector3d tip_in_ct_mm = Eigen::Vector3d::Zero();  ///< At the last usable sample.
  double tip_deflection_mm = 0.0;  ///< Distance from the line along which the hub points.
};

/// A value: copy it to save, assign it to restore. Made by NeedleShapeModel::NewState.
struct NeedleShapeState {
  forces::SampleGate gate;  ///< Holds the force and torque across the path.
  PathLine line;            ///< At the last sample that was stepped on.
  double depth_mm = 0.0;
  needle::BendableNeedleState needle;  ///< Empty except for the model bendable.
  NeedleShape shape;
  Eigen::Vector3d tip_direction_in_ct = Eigen::Vector3d::Zero();  ///< Zero: along the needle.
  /// From the device's tip to the bent one, across the device's axis.
  Eigen::Vector3d tip_offset_mm = Eigen::Vector3d::Zero();
  HandEnergy hand;
};

/// Const after construction: any number of states may step side by side.
class NeedleShapeModel {
 public:
  /// @param table  Limits, lost tracking, and tissue across the path are read from it.
  /// @param elasticity  Constants of the scene's tissues; null unless the model is bendable.
  /// @param tissues  Labels of the scene; those that can be deformed need elastic constants.
  /// @param force_has_beam  The force model already has the beam across its path.
  /// @throws InputError if a setting is out of range or a tissue has no elastic constants.
  NeedleShapeModel(const scenario::NeedleEffect& effect, const needle::NeedleProperties& needle,
                   const forces::ForceTable& table, const mechanics::ElasticityTable* elasticity,
                   const std::bitset<256>& tissues, bool force_has_beam);

  NeedleShapeState NewState() const;

  /// Moves and bends the needle, and replaces the part of `force` across the path. Treats bad
  /// samples as forces::NeedleForceModel::Step does; the sum keeps the table's largest_force_n.
  /// Allocates nothing.
  void Step(NeedleShapeState& state, const NeedleShapeInput& input,
            forces::NeedleForce& force) const noexcept;

  /// The needle from the tip to the hub, in CT space. False, with `out` unchanged, if the needle is
  /// straight in the hand.
  bool ShapeOf(const NeedleShapeState& state, math::Polyline& out) const noexcept;

  /// After the puncture: the axis that the needle is held to; else `axis_in_ct`.
  const Eigen::Vector3d& LockedAxis(const NeedleShapeState& state,
                                    const Eigen::Vector3d& axis_in_ct) const noexcept {
    return axis_lock_ && state.line.pierced ? state.line.direction_in_ct : axis_in_ct;
  }

  /// After the puncture: the tip on the path that the needle is held to, as deep as the hand's;
  /// else `tip_in_ct_mm`, and also where the hand is so far off the path that it has let go.
  Eigen::Vector3d LockedTip(const NeedleShapeState& state,
                            const Eigen::Vector3d& tip_in_ct_mm) const noexcept;

  /// True if the needle is not in the body: there is nothing to compute.
  bool IsAsleep(const NeedleShapeState& state) const noexcept { return !state.line.pierced; }

  const std::optional<needle::BendableNeedle>& bendable() const { return bendable_; }
  /// Stiffness of the tissue across a shaft, N/mm per mm of its length, by label.
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
  bool keeps_force_;  ///< lateral_beam, and the force model has its force.
  needle::NeedleProperties needle_;
  forces::ForceSettings settings_;
  std::optional<needle::BendableNeedle> bendable_;
  std::array<double, 256> stiffness_n_per_mm2_{};
};

}  // namespace acus::simulation
