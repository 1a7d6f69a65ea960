// The one equation of a step: the sum of the forces on the plunger, or of the pressures at an open
// hub, as a monotone function of the pressure at the bevel.
#pragma once

#include "acus/physics/fluid/bevel_flow.h"
#include "acus/physics/fluid/lumen.h"
#include "acus/physics/fluid/syringe.h"

namespace acus::fluid {

/// Values that a step starts from, and what drives the plunger.
struct PlungerEquation {
  const Syringe* syringe = nullptr;  ///< Null: the hub is open.
  BevelLaw law;
  LumenResistance lumen;
  double expansion = 1.0;  ///< Volume in the tissue per volume that leaves the syringe; > 0.
  double dt_s = 0.0;
  double liquid_ml = 0.0;
  double air_ml = 0.0;
  double start_mm = 0.0;
  double start_mm_per_s = 0.0;
  double stick_mm = 0.0;
  double stick_n_s_per_mm = 0.0;  ///< Damping of the stopper that sticks.
  double yield_n = 0.0;           ///< Friction at which the stopper slips.
  double hand_n = 0.0;            ///< Constant part of the hand's force,
  double hand_n_per_mm = 0.0;     ///< less this times the travel of the step,
  double hand_n_s_per_mm = 0.0;   ///< less this times its speed.

  struct Point {
    double residual = 0.0;  ///< N at a plunger, kPa at an open hub.
    double slope = 0.0;     ///< By the pressure at the bevel, > 0.
    BevelFlow flow;
    double needle_ml_per_s = 0.0;
    double syringe_kpa = 0.0;
    double plunger_mm = 0.0;
    double resisting_n = 0.0;  ///< Pressure, friction and stops.
    double stick_mm = 0.0;
    double scale = 1.0;  ///< Of what the residual is the sum of.
  };

  Point At(double bevel_kpa) const noexcept;

  struct Root {
    Point point;
    double bevel_kpa = 0.0;
    int iterations = 0;
  };
  /// Newton, held between the pressures where the sign differs; bisection where it is slow.
  Root Solve(double guess_kpa, int max_iterations) const noexcept;
};

}  // namespace acus::fluid
