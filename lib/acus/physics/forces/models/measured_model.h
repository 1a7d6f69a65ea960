// The force on a needle as recordings of the tissue have it: resistance in and out by depth since
// the contact, build-up, relaxation while the needle rests, internal punctures.
//
// The law is MechanicalModel, as acus-fit fits it (docs/models/force_fit.md); what is across the
// path, bone, samples that cannot be used and the bound on the force are the layered model's.
#pragma once

#include "acus/physics/forces/models/mechanical_model.h"
#include "acus/physics/forces/models/needle_force.h"

namespace acus::forces {

/// The state of the model between steps. A plain value: copy it to save, assign it to restore.
struct MeasuredState : NeedleForceState {
  MechanicalState contact;
};

/// The model of one needle. Const after construction: any number of states may step side by side.
class MeasuredModel {
 public:
  /// @param table  gives bone, guidance, bounds and what happens when tracking is lost; its soft
  ///     rows are not read: `law` says what soft tissue does.
  /// @param law_diameter_mm  outer diameter of the needle that was recorded. Forces scale with it.
  MeasuredModel(const ForceTable& table, const NeedleProperties& needle, MechanicalModel law,
                double law_diameter_mm, GuidanceKind guidance = GuidanceKind::kOwn);

  /// Takes in the next sample, as NeedleForceModel::Step: bad samples and the bound on the force
  /// are treated as there. Exact for constant speed between samples, however far apart they are.
  /// Allocates nothing. puncture_n is what internal punctures add to the resistance, friction_n all
  /// the rest: a recording does not distinguish cutting from friction at one depth. cutting_n is 0.
  NeedleForce Step(MeasuredState& state, const NeedleInput& input) const noexcept;

  const ForceTable& table() const { return layered_.table(); }
  const MechanicalModel& law() const { return law_; }

 private:
  bool PassesPuncture(double from_mm, double to_mm) const noexcept;

  NeedleForceModel layered_;  ///< With a table in which soft tissue does nothing.
  MechanicalModel law_;
};

}  // namespace acus::forces
