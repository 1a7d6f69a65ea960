// Flow through a needle: Hagen and Poiseuille, with the losses at entrance and exit.
//
//   dp = R q + K q |q|,   R = 128 mu L / (pi d^4),   K = loss rho / (2 A^2)
//
// mu: viscosity; L: length; d: inner diameter; A: cross-section; loss: of kinetic energy at
// entrance and exit together, 2.16 for a developed laminar profile that is lost (Langhaar 1942).
// Equations, sources, limits: docs/models/fluid.md.
#pragma once

#include <string>

namespace acus::fluid {

struct Fluid {
  double viscosity_mpa_s = 0.7;  ///< Saline and cerebrospinal fluid at 37 degrees.
  double density_kg_per_m3 = 1000.0;
};

/// Air at 20 degrees and atmospheric pressure.
inline constexpr Fluid kAir{0.0181, 1.2};

struct Lumen {
  double inner_diameter_mm = 0.84;
  double length_mm = 90.0;
  /// Narrower last part of a tapered needle; 0: none.
  double tip_inner_diameter_mm = 0.0;
  double tip_length_mm = 0.0;

  double VolumeMl() const noexcept;
};

/// Pressure over flow of a lumen filled with one fluid.
struct LumenResistance {
  double linear_kpa_s_per_ml = 0.0;       ///< R.
  double quadratic_kpa_s2_per_ml2 = 0.0;  ///< K.

  double PressureKpa(double flow_ml_per_s) const noexcept {
    const double magnitude = flow_ml_per_s < 0.0 ? -flow_ml_per_s : flow_ml_per_s;
    return (linear_kpa_s_per_ml + quadratic_kpa_s2_per_ml2 * magnitude) * flow_ml_per_s;
  }
  /// Exact inverse of PressureKpa. @pre linear > 0.
  double FlowMlPerS(double pressure_kpa) const noexcept;
};

inline constexpr double kKineticLoss = 2.16;

LumenResistance ResistanceOf(const Lumen& lumen, const Fluid& fluid,
                             double kinetic_loss = kKineticLoss) noexcept;

}  // namespace acus::fluid
