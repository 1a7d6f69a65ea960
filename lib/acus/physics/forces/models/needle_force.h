// The force on a needle from where its tip is and which tissue is there: one step per sample.
//
// The model is one-dimensional along the path that the needle makes when it pierces the skin
// (docs/models/needle_forces.md): membranes indented and punctured (Alamilla-2021 eq. 2), cutting
// by a tracking wall (eq. 3), friction along the buried shaft with bristles (eq. 4-6 without the
// velocity terms), relaxation, rate and rest where a tissue has them (shaft_friction.h), bone as a
// proxy (Vidal-2008 eq. 7), and across the path a beam on a soft foundation (Augmented-2010,
// section II.D). Tissue does not deform in this model: the tip of the device is the tip of the
// needle, except on bone.
#pragma once

#include "acus/physics/forces/laws/force_laws.h"
#include "acus/physics/forces/laws/force_table.h"
#include "acus/physics/forces/laws/shaft_friction.h"
#include "acus/physics/forces/path/guidance.h"
#include "acus/physics/forces/path/needle_sample.h"
#include "acus/physics/forces/path/needle_track.h"

namespace acus::forces {

/// Stiffness across the path of a needle this deep: the free part of the shaft as a cantilever, in
/// series with the tissue around the buried part (Augmented-2010, section II.D). N/mm.
double LateralStiffnessNPerMm(const NeedleProperties& needle, const ForceSettings& settings,
                              double depth_mm) noexcept;

/// The state of the model between steps. A plain value: copy it to save, assign it to restore.
struct NeedleForceState : NeedleTrack {
  TrackingWall wall;
  BristleFriction bristle;
  // In place of the bristle, and beside the wall, where the force depends on time.
  ShaftFrictionState shaft;
  std::array<double, ForceRelaxation::kMostTerms> crept_wall_mm{};
  double walls_n = 0.0;        ///< Force of all walls.
  volume::Label walls_of = 0;  ///< Tissue that the walls are of.
  GuidanceState guide;
  bool redirecting = false;  ///< Withdrawn far enough to be turned to a new path.
  double lowest_mm = 0.0;    ///< Least depth since then.
};

/// The model of one needle. Const after construction: any number of states may step side by side.
class NeedleForceModel {
 public:
  /// The table is scaled to the needle's diameter.
  NeedleForceModel(const ForceTable& table, const NeedleProperties& needle,
                   GuidanceKind guidance = GuidanceKind::kOwn);

  /// Takes in the next sample. Cost O(tissues met on the path); under 1 us.
  ///  - a value that is not finite, or an axis of length 0: zero force, counted, state kept;
  ///  - time not later than before: the held force, counted, state kept;
  ///  - invalid: the held force, which falls to zero after the table's tracking_loss times.
  /// The magnitude of the force never exceeds the table's largest_force_n.
  NeedleForce Step(NeedleForceState& state, const NeedleInput& input) const noexcept;

  const ForceTable& table() const { return table_; }
  const NeedleProperties& needle() const { return needle_; }

  double LateralStiffnessNPerMm(double depth_mm) const noexcept {
    return forces::LateralStiffnessNPerMm(needle_, table_.settings, depth_mm);
  }

 private:
  NeedleForce InBody(NeedleForceState& state, const NeedleMotion& motion,
                     bool touched) const noexcept;
  void Guide(NeedleForceState& state, const NeedleMotion& motion) const noexcept;
  void Redirect(NeedleForceState& state, const NeedleMotion& motion) const noexcept;
  void TipForces(NeedleForceState& state, const TipMove& move, NeedleForce& out) const noexcept;
  double CuttingN(NeedleForceState& state, const TipMove& move) const noexcept;
  double FrictionN(NeedleForceState& state, double shaft_mm) const noexcept;
  void Finish(NeedleForceState& state, const NeedleMotion& motion, bool was_pierced,
              NeedleForce& out) const noexcept;

  ForceTable table_;
  NeedleProperties needle_;
  GuidanceKind guidance_;
  ShaftFriction shaft_;
  TipGrip grip_;
};

}  // namespace acus::forces
