// Events of an injection, from the outputs of the steps.
#pragma once

#include "acus/physics/fluid/fluid_model.h"

namespace acus::fluid {

/// Limits for events.
struct FluidEventLimits {
  double armed_kpa = 6.7;     ///< Pressure that counts as resistance, 50 mmHg.
  double fall_share = 0.5;    ///< Of the highest pressure since: the fall that is a loss.
  double within_s = 3.0;      ///< The time that the fall may take.
  double injected_ml = 0.05;  ///< That must flow in that time: a thumb that lets go is no loss.
  double high_kpa = 103.4;    ///< 15 psi: limit for injections near nerves.
};

/// Follows one injection. A plain value.
struct FluidEvents {
  bool lost_resistance = false;  ///< In this step.
  double peak_kpa = 0.0;         ///< In the syringe, since the start.
  double above_limit_s = 0.0;    ///< Time above high_kpa.
  double before_loss_kpa = 0.0;  ///< Highest pressure before the last loss.
  double fall_time_s = 0.0;      ///< Of the last loss, from 90 % of that to 1 - fall_share.
  int num_losses = 0;
  int num_drops = 0;           ///< At an open hub, since it was opened.
  double drops_per_min = 0.0;  ///< Over the last drops; 0 if none fell lately.

  /// @param dt_s  > 0, of the step that gave `output`.
  void Advance(const FluidEventLimits& limits, const FluidOutput& output, double dt_s) noexcept;

  double top_kpa = 0.0;       ///< Highest pressure lately.
  double since_high_s = 0.0;  ///< Since it was within a tenth of that.
  double since_high_ml = 0.0;
  bool armed = false;
  double drop_ml = 0.0;  ///< Of the drop that hangs at the hub.
  double since_drop_s = 0.0;
};

}  // namespace acus::fluid
