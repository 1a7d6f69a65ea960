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

namespace acus::fluid {

inline constexpr int kMaxShells = 16;

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
  /// @param time_s  a^2/D > 0.  @param num_shells  1 to kMaxShells.
  TissueSpread(double steady_kpa_s_per_ml, double time_s, int num_shells) noexcept;

  /// What a step of `dt_s` > 0 from `state` makes of any flow.
  Response ResponseOf(const State& state, double dt_s) const noexcept;
  /// The step, with the flow that was found.
  void Advance(State& state, double flow_ml_per_s, double dt_s) const noexcept;
  /// Fluid that the shells store above rest, ml.
  double StoredMl(const State& state) const noexcept;

 private:
  int num_ = 0;
  std::array<double, kMaxShells> storage_ml_per_kpa_ = {};
  std::array<double, kMaxShells> out_ml_per_kpa_s_ = {};  ///< Conductance to the next shell.
};

}  // namespace acus::fluid
