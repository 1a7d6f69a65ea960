// A mass that is pulled to where a hand wants it, and pushed by a force: one step of its motion.
#pragma once

#include <Eigen/Core>

namespace acus::math {

struct DrivenMass {
  double mass_kg = 0.1;
  double damping_n_s_per_mm = 0.0;  ///< Against the world.
  double hand_n_per_mm = 0.0;       ///< Spring to where the hand wants it.
  double hand_n_s_per_mm = 0.0;     ///< Damper to how fast the hand moves.
  double dry_friction_n = 0.0;

  struct State {
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_mm_s = Eigen::Vector3d::Zero();
    Eigen::Vector3d wanted_mm = Eigen::Vector3d::Zero();  ///< By the hand, at the last step.
  };

  /// Semi-implicit Euler, damping implicitly: stable for any damping. Returns the way of the step,
  /// mm. @pre dt_s > 0, mass_kg > 0.
  Eigen::Vector3d Step(State& state, const Eigen::Vector3d& wanted_mm,
                       const Eigen::Vector3d& force_n, double dt_s) const noexcept {
    const double per_mass = 1e3 / mass_kg;  // N to mm/s^2.
    const double implicit = 1.0 + dt_s * per_mass * (damping_n_s_per_mm + hand_n_s_per_mm);
    const Eigen::Vector3d pull_n = force_n + hand_n_per_mm * (wanted_mm - state.place_mm) +
                                   hand_n_s_per_mm * (wanted_mm - state.wanted_mm) / dt_s;
    state.wanted_mm = wanted_mm;
    state.velocity_mm_s = (state.velocity_mm_s + dt_s * per_mass * pull_n) / implicit;
    // What dry friction takes off the speed; slower than that it holds the mass.
    const double stopped_mm_s = dt_s * per_mass * dry_friction_n / implicit;
    const double speed_mm_s = state.velocity_mm_s.norm();
    state.velocity_mm_s *= speed_mm_s > stopped_mm_s ? 1.0 - stopped_mm_s / speed_mm_s : 0.0;
    const Eigen::Vector3d travel_mm = dt_s * state.velocity_mm_s;
    state.place_mm += travel_mm;
    return travel_mm;
  }
};

}  // namespace acus::math
