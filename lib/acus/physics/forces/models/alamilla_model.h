// The force on a needle after Alamilla-2021, all of eq. 1 to 12.
//
// Before the puncture a polynomial, then a tracking wall for cutting and withdrawal, LuGre
// friction, a virtual fixture that clamps the needle's direction and place, and a knock on bone.
// Tissues and events are those of the layered model. Equations and decisions:
// docs/models/forces_alamilla.md.
#pragma once

#include "acus/physics/forces/laws/force_laws.h"
#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/hard_contact.h"
#include "acus/physics/forces/laws/lugre.h"
#include "acus/physics/forces/path/guidance.h"
#include "acus/physics/forces/path/needle_sample.h"
#include "acus/physics/forces/path/needle_track.h"

namespace acus::forces {

/// The state of the model between steps. A plain value: copy it to save, assign it to restore.
struct AlamillaState : NeedleTrack {
  TrackingWall wall;
  double wall_n = 0.0;         ///< Its last force.
  double wall_n_per_mm = 0.0;  ///< Its last stiffness.
  volume::Label held_by = 0;   ///< The tissue around the tip, also in the channel.
  LuGre friction;
  HardContact knock;
  GuidanceState guide;
};

/// The model of one needle. Const after construction: any number of states may step side by side.
class AlamillaModel {
 public:
  /// The table is scaled to the needle's diameter.
  AlamillaModel(const ForceTable& table, const NeedleProperties& needle,
                GuidanceKind guidance = GuidanceKind::kOwn);

  /// Takes in the next sample. Bad samples and the bound on the force: as NeedleForceModel::Step.
  /// cutting_n is below 0 while the needle is withdrawn. Each layer holds the tip by its own force,
  /// also on its way out and in again. lateral_n and torque_in_ct_n_mm clamp it.
  NeedleForce Step(AlamillaState& state, const NeedleInput& input) const noexcept;

  const ForceTable& table() const { return table_; }

 private:
  NeedleForce InBody(AlamillaState& state, const NeedleMotion& motion, bool touched) const noexcept;
  void AlongThePath(AlamillaState& state, const NeedleMotion& motion, const TrackStep& step,
                    NeedleForce& out) const noexcept;
  double WallN(AlamillaState& state, double previous_mm) const noexcept;

  ForceTable table_;
  GuidanceKind guidance_;
};

}  // namespace acus::forces
