// Clamping: tissue that holds a needle on the trajectory that it took, Alamilla-2021 eq. 7 to 11.
//
// A bilateral fixture for direction and place, with stiffness and damping. It yields beyond its
// limits, and takes a new trajectory when a turned needle is advanced.
#pragma once

#include <Eigen/Geometry>

namespace acus::forces {

struct FixtureSettings {
  double angular_n_mm_per_rad = 0.0;            ///< k of eq. 11, on the orientation error.
  double angular_damping_n_mm_s_per_rad = 0.0;  ///< B of eq. 11.
  double torque_limit_n_mm = 0.0;               ///< Beyond it the trajectory turns along.
  double lateral_n_per_mm = 0.0;                ///< The same for the tip off the trajectory's line.
  double lateral_damping_n_s_per_mm = 0.0;
  double force_limit_n = 0.0;
  double redefine_mm = 0.0;  ///< Advance in which a new trajectory takes over (to 1/e), > 0.
};

/// What the fixture holds on to. A plain value.
struct Fixture {
  Eigen::Quaterniond ct_from_reference = Eigen::Quaterniond::Identity();  ///< q0.
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  ///< Tip off the trajectory, across it.
  double angle_rad = 0.0;                               ///< Of the orientation error.

  /// The trajectory's direction: +z of the reference.
  Eigen::Vector3d DirectionInCt() const noexcept {
    return ct_from_reference * Eigen::Vector3d::UnitZ();
  }
};

struct FixtureMotion {
  Eigen::Quaterniond ct_from_needle = Eigen::Quaterniond::Identity();  ///< q_c; unit length.
  Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero();  ///< Of the tip from the trajectory now.
  Eigen::Vector3d angular_velocity_rad_per_s = Eigen::Vector3d::Zero();  ///< CT axes.
  Eigen::Vector3d velocity_mm_per_s = Eigen::Vector3d::Zero();           ///< Of the tip.
  double advance_mm = 0.0;  ///< Into fresh tissue in this step, >= 0.
};

struct FixtureForce {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();      ///< On the needle, across the trajectory.
  Eigen::Vector3d torque_n_mm = Eigen::Vector3d::Zero();  ///< About the tip; both in CT axes.
  bool trajectory_moved = false;
};

/// Eq. 7 to 10: the rotation vector from the needle's orientation back to the reference, in the
/// needle's own axes; its length is the angle, in [0, pi]. The same for q and -q.
Eigen::Vector3d OrientationErrorRad(const Eigen::Quaterniond& ct_from_reference,
                                    const Eigen::Quaterniond& ct_from_needle) noexcept;

/// The orientation that is nearest to `ct_from_reference` and has its +z along `axis_in_ct`: a hand
/// that turns the needle about itself is not held.
/// @pre axis_in_ct has unit length.
Eigen::Quaterniond WithoutTwist(const Eigen::Quaterniond& ct_from_reference,
                                const Eigen::Vector3d& axis_in_ct) noexcept;

/// One step: turns and shifts the trajectory where the needle advanced or the limits were passed
/// (each only lowers the energy in the fixture), then gives the force of what remains.
FixtureForce StepFixture(const FixtureSettings& settings, Fixture& fixture,
                         const FixtureMotion& motion) noexcept;

}  // namespace acus::forces
