// Spread of injected fluid from the bevel through porous elastic tissue: Darcy's law with storage,
// around a cavity of radius a.
//
//   S dp/dt = (k/mu) (1/r^2) d/dr (r^2 dp/dr),   q = -Omega a^2 (k/mu) dp/dr at r = a
//
// k/mu: mobility; S: storage, fluid per volume and pressure; Omega: solid angle, 4 pi in a solid, 2
// pi at an impermeable face. Steady: p(a) = R q with R = mu / (Omega k a); approached with the time
// constant a^2/D, D = k / (mu S). Shells of growing thickness, backward Euler: stable for any step.
// Equations, limits, accuracy: docs/models/fluid.md.
#pragma once

#include <array>
#include <numbers>

#include "acus/physics/fluid/lumen.h"

namespace acus::fluid {

/// R = mu / (Omega k a). @param permeability_m2  k.  @param solid_angle_sr  2 pi at an impermeable
/// face that the cavity lies at.
inline double DarcyKpaSPerMl(const Fluid& fluid, double permeability_m2, double radius_mm,
                             double solid_angle_sr = 4.0 * std::numbers::pi) noexcept {
  // mPa s / (m^2 mm) = Pa s/m^3 = 1e-9 kPa s/ml.
  return 1e-9 * fluid.viscosity_mpa_s / (solid_angle_sr * permeability_m2 * radius_mm);
}

/// a^2 / D with D = k M / mu. @param modulus_kpa  M: stress per strain of the drained tissue,
/// confined.
inline double DarcyTimeS(const Fluid& fluid, double permeability_m2, double modulus_kpa,
                         double radius_mm) noexcept {
  // mm^2 mPa s / (m^2 kPa) = 1e-12 s.
  return 1e-12 * radius_mm * radius_mm * fluid.viscosity_mpa_s / (permeability_m2 * modulus_kpa);
}

inline constexpr int kMaxShells = 32;

/// The shells of a spread. Const.
class TissueSpread {
 public:
  /// Pressures above the resting pressure, from the cavity outwards. A plain value.
  struct State {
    std::array<double, kMaxShells> kpa = {};
  };
  /// After a step with flow q the pressure in the cavity is free_kpa + kpa_s_per_ml * q.
  struct Response {
    double free_kpa = 0.0;
    double kpa_s_per_ml = 0.0;
  };

  TissueSpread() = default;
  /// @param steady_kpa_s_per_ml  R >= 0; 0: no resistance, pressures stay 0.
  /// @param time_s  a^2/D > 0.  @param num_shells  2 to kMaxShells.
  TissueSpread(double steady_kpa_s_per_ml, double time_s, int num_shells) noexcept;

  /// What a step of `dt_s` > 0 from `state` makes of any flow.
  Response ResponseOf(const State& state, double dt_s) const noexcept;
  /// The step, with the flow that was found.
  void Advance(State& state, double flow_ml_per_s, double dt_s) const noexcept;
  /// Fluid that the shells store above rest, ml.
  double StoredMl(const State& state) const noexcept;

 private:
  /// What each shell and those beyond it make of flow into it: (stored + out) p = right + inflow.
  struct Sweep {
    std::array<double, kMaxShells> diagonal;
    std::array<double, kMaxShells> right;
  };
  Sweep Eliminate(const State& state, double dt_s) const noexcept;

  int num_ = 0;
  std::array<double, kMaxShells> storage_ml_per_kpa_ = {};
  std::array<double, kMaxShells> out_ml_per_kpa_s_ = {};  ///< Conductance to the next shell.
};

}  // namespace acus::fluid
