// A syringe: barrel, plunger with stick and sliding friction, and its filling.
//
// Units throughout the module: pressures in kPa above atmospheric pressure, volumes in ml, flow in
// ml/s, lengths in mm, forces in N. They are coherent: kPa x ml/mm = N, kPa x ml = N mm = mJ.
#pragma once

#include <numbers>
#include <string>

namespace acus::fluid {

inline constexpr double kAtmosphericKpa = 101.325;

struct Syringe {
  std::string name;
  double capacity_ml = 10.0;
  double bore_mm = 15.0;                 ///< Inner diameter of the barrel.
  double dead_space_ml = 0.1;            ///< In the nozzle, plunger fully in.
  double compliance_ml_per_kpa = 0.0;    ///< Barrel and stopper; >= 0.
  double static_friction_n = 0.0;        ///< Breaks the plunger loose; >= sliding_friction_n.
  double sliding_friction_n = 0.0;       ///< At speed; >= 0.
  double stribeck_speed_mm_per_s = 1.0;  ///< How fast one becomes the other, > 0.
  double stick_n_per_mm = 20.0;          ///< Stopper that sticks to the barrel, > 0.
  double viscous_n_s_per_mm = 0.0;       ///< Lubricant; >= 0.
  double plunger_mass_kg = 0.005;        ///< > 0.

  /// Volume per travel, which is also force per pressure: ml/mm = N/kPa.
  double AreaMlPerMm() const noexcept { return 0.25e-3 * std::numbers::pi * bore_mm * bore_mm; }
  /// Travel from the mark of the capacity to the end of the barrel.
  double StrokeMm() const noexcept { return capacity_ml / AreaMlPerMm(); }
};

/// At atmospheric pressure.
struct Filling {
  double volume_ml = 5.0;  ///< Of liquid and air together, 0 to the syringe's capacity.
  double air_share = 0.0;  ///< Of volume_ml: 0 saline only, 1 air only.
};

/// Friction at the plunger: a spring that yields at a limit, which falls from static to sliding
/// friction with the speed of slip in the previous step (Stribeck).
struct PlungerFriction {
  double stick_mm = 0.0;       ///< Elastic part of the travel.
  double slip_mm_per_s = 0.0;  ///< Of the rest, in the previous step.
};

}  // namespace acus::fluid
