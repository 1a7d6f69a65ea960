// The force on a needle by any of the models, chosen by the scene.
#pragma once

#include <variant>

#include "acus/physics/forces/models/alamilla_model.h"
#include "acus/physics/forces/models/measured_model.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/forces/models/vidal_model.h"
#include "acus/physics/forces/path/swept_step.h"

namespace acus::forces {

/// All that a model remembers. A plain value: copy it to save, assign it to restore.
using ForceState = std::variant<NeedleForceState, AlamillaState, VidalState, MeasuredState>;

/// What all states share: where the needle is in the body, and what was wrong with samples.
const NeedleTrack& TrackOf(const ForceState& state) noexcept;

/// One of the models. Const after construction: any number of states may step side by side.
class ForceModel {
 public:
  using Model = std::variant<NeedleForceModel, AlamillaModel, VidalModel, MeasuredModel>;
  explicit ForceModel(Model model) : model_(std::move(model)) {}

  ForceState NewState() const;

  /// Takes in the next sample, as NeedleForceModel::Step. Allocates nothing.
  /// @pre `state` is of this model.
  NeedleForce Step(ForceState& state, const NeedleInput& input) const noexcept;

  /// The same for a tip that has moved since the last sample: what lies on its way is met in order,
  /// each event within SweepLimits::kResolvedMm of where it is. The force is that at the sample,
  /// its event the first of NeedleEvent's order. A sample that moves the tip no farther than that,
  /// or that comes when the force of the last one has faded, is one Step, bit for bit. Cost: that
  /// of Step times two for each tissue met; below 50 us for any sample.
  /// @param events  What happened, in order; cleared first.
  NeedleForce StepAlong(ForceState& state, const NeedleInput& input, const SweptTissue& tissue,
                        PassedEvents& events) const noexcept;

  const ForceTable& table() const;

 private:
  Model model_;
};

}  // namespace acus::forces
