// The elementary laws of needle insertion, each rate-independent or unconditionally stable.
//
// All are one-dimensional along the needle's path: positions in mm, + into the tissue; forces in N
// on the needle, + pushes it out. States are plain values; every function is noexcept, allocates
// nothing and gives the same bits for the same input. Equations: docs/models/needle_forces.md.
#pragma once

namespace acus::forces {

/// A membrane (skin, capsule, ligament) indented before it yields: f = a1 x + a2 x^2 up to the
/// puncture force. Alamilla-2021 eq. 2.
struct PuncturePolynomial {
  double a1_n_per_mm = 0.0;   ///< >= 0.
  double a2_n_per_mm2 = 0.0;  ///< >= 0.
  double puncture_n = 0.0;    ///< >= 0; 0 means that there is no membrane.

  /// @param indentation_mm  below 0 gives 0.
  double ForceN(double indentation_mm) const noexcept;

  /// Indentation at which the puncture force is reached; 0 without a membrane, infinite if the
  /// polynomial is 0 everywhere.
  double PunctureDepthMm() const noexcept;
};

/// Cutting as a spring to a wall that the tip pushes ahead of itself: elastic up to the cutting
/// force, then the wall follows, so standing still or reversing cannot chatter (the tracking wall,
/// Alamilla-2021 eq. 3). One-sided: nothing pulls on a tip that moves back.
struct TrackingWall {
  double wall_mm = 0.0;  ///< Where the spring is at rest.

  /// Moves the wall for a tip at `tip_mm` and returns the force, in [0, cutting_n].
  /// @pre stiffness_n_per_mm > 0, cutting_n >= 0.
  double Advance(double tip_mm, double cutting_n, double stiffness_n_per_mm) noexcept;

  /// The same with a wall that also follows a tip that is withdrawn, as in the paper: the spring
  /// then pulls, by up to withdrawal_n. Returns the force, in [-withdrawal_n, cutting_n].
  double AdvanceBothWays(double tip_mm, double cutting_n, double withdrawal_n,
                         double stiffness_n_per_mm) noexcept;
};

/// The direct method: the whole force as soon as the tip is behind the wall. It chatters
/// (Alamilla-2021, section VI.A); here to compare with.
inline double DirectMethodN(double depth_mm, double force_n) noexcept {
  return depth_mm > 0.0 ? force_n : 0.0;
}

/// Dry friction with elastic bristles: LuGre (Alamilla-2021 eq. 4-6) without its velocity terms,
///   dz/ds = 1 - sign(ds) z / z0,
/// integrated exactly over each displacement: stable for any step, and the same force for a path
/// however it is cut into steps.
struct BristleFriction {
  double deflection_mm = 0.0;  ///< z, in [-z0, z0].

  /// @param travel_mm  tip displacement since the last call, + into the tissue.
  /// @param z0_mm      travel over which friction builds up, > 0.
  /// @return z / z0 in [-1, 1]: the fraction of the full sliding friction.
  double Slide(double travel_mm, double z0_mm) noexcept;
};

/// Bone: the tip stays at the surface, the device is pulled back to it by a spring-damper that
/// never pulls the needle in (the proxy of Vidal-2008 eq. 7).
struct BoneSpring {
  double stiffness_n_per_mm = 0.0;
  double damping_n_s_per_mm = 0.0;
  double largest_n = 0.0;

  /// @param penetration_mm  of the device beyond the surface; @param speed_mm_per_s  + inwards.
  double ForceN(double penetration_mm, double speed_mm_per_s) const noexcept;
};

}  // namespace acus::forces
