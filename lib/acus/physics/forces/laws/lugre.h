// Dynamic friction with elastic bristles and the Stribeck effect: LuGre, Alamilla-2021 eq. 4 to 6.
//
//   dz/dt = v - sigma0 |v| / g(v) z,   g(v) = mu_c + (mu_s - mu_c) exp(-beta |v|)
//   F = F_n (sigma0 z + sigma1 dz/dt + sigma2 v)
//
// Solved exactly over each step's displacement, as |v| dt is what bends the bristles: stable for
// any speed and any step. Equations and decisions: docs/models/forces_alamilla.md.
#pragma once

namespace acus::forces {

struct LuGreParameters {
  double sigma0_per_mm = 0.0;    ///< Bristle stiffness, > 0.
  double sigma1_s_per_mm = 0.0;  ///< Bristle damping, >= 0.
  double sigma2_s_per_mm = 0.0;  ///< Viscous part, >= 0.
  double mu_coulomb = 0.0;       ///< Friction coefficient at speed, > 0.
  double mu_static = 0.0;        ///< At rest, > 0.
  double beta_s_per_mm = 0.0;    ///< How fast one becomes the other, >= 0.
  double speed_filter_s = 0.0;   ///< Time constant of the speed that g and sigma2 see, >= 0.

  /// g(v), eq. 5: the coefficient that steady sliding without sigma2 has.
  double Stribeck(double speed_mm_per_s) const noexcept;
};

/// The state of the bristles. A plain value.
struct LuGre {
  double bristle_mm = 0.0;         ///< z.
  double filtered_mm_per_s = 0.0;  ///< Speed without the steps of an encoder.
  double normal_n = 0.0;           ///< F_n of the last step.

  /// One step. Passive: the energy given back is never more than what bent the bristles.
  ///  - g sees a filtered speed, because an encoder's steps look like a tremor at high speed; any
  ///    positive g is passive;
  ///  - sigma1 is held at 4 g / |v| or less, above which LuGre gives energy to the hand;
  ///  - where F_n rises, z shrinks so that the force is continuous, not the stored energy rises.
  /// @param travel_mm  displacement in this step, + into the tissue.
  /// @param dt_s  > 0.  @param normal_n  F_n >= 0.
  /// @return the force against the motion, + pushes the needle out.
  double Advance(const LuGreParameters& law, double travel_mm, double dt_s,
                 double normal_n) noexcept;
};

}  // namespace acus::forces
