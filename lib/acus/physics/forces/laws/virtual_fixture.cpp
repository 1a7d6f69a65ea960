#include "acus/physics/forces/laws/virtual_fixture.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

/// The factor by which an error shrinks so that its force is within the limit.
double GivesWayTo(double force, double limit) noexcept {
  return force > limit ? limit / force : 1.0;
}

Eigen::Vector3d Limited(const Eigen::Vector3d& value, double limit) noexcept {
  const double size = value.norm();
  return size > limit ? Eigen::Vector3d(value * (limit / size)) : value;
}

Eigen::Quaterniond FromRotationVector(const Eigen::Vector3d& vector_rad) noexcept {
  const double angle = vector_rad.norm();
  if (angle < 1e-300) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, vector_rad / angle));
}

}  // namespace

Eigen::Vector3d OrientationErrorRad(const Eigen::Quaterniond& ct_from_reference,
                                    const Eigen::Quaterniond& ct_from_needle) noexcept {
  const Eigen::Quaterniond q = ct_from_needle.conjugate() * ct_from_reference;  // Eq. 7.
  const double norm = q.vec().norm();                                           // Eq. 9.
  if (norm < 1e-12) return 2.0 * (q.w() < 0.0 ? -1.0 : 1.0) * q.vec();
  const double angle = 2.0 * std::atan2(norm, std::abs(q.w()));  // Eq. 8.
  return q.vec() * (std::copysign(angle, q.w()) / norm);         // Eq. 10, for q and -q alike.
}

Eigen::Quaterniond WithoutTwist(const Eigen::Quaterniond& ct_from_reference,
                                const Eigen::Vector3d& axis_in_ct) noexcept {
  const Eigen::Vector3d from = ct_from_reference * Eigen::Vector3d::UnitZ();
  const double cosine = from.dot(axis_in_ct);
  if (cosine <
      -1.0 + 1e-12) {  // Turned right round: any perpendicular axis will do, always the same.
    const Eigen::Vector3d across = ct_from_reference * Eigen::Vector3d::UnitX();
    return (Eigen::Quaterniond(0.0, across.x(), across.y(), across.z()) * ct_from_reference)
        .normalized();
  }
  const Eigen::Vector3d cross = from.cross(axis_in_ct);
  return (Eigen::Quaterniond(1.0 + cosine, cross.x(), cross.y(), cross.z()).normalized() *
          ct_from_reference)
      .normalized();
}

FixtureForce StepFixture(const FixtureSettings& settings, Fixture& fixture,
                         const FixtureMotion& motion) noexcept {
  Eigen::Vector3d error_rad = OrientationErrorRad(fixture.ct_from_reference, motion.ct_from_needle);
  fixture.offset_mm = motion.offset_mm;
  const double kept = std::exp(-std::max(0.0, motion.advance_mm) / settings.redefine_mm);
  const double kept_angle =
      kept * GivesWayTo(kept * settings.angular_n_mm_per_rad * error_rad.norm(),
                        settings.torque_limit_n_mm);
  const double kept_offset =
      kept * GivesWayTo(kept * settings.lateral_n_per_mm * fixture.offset_mm.norm(),
                        settings.force_limit_n);
  if (kept_angle < 1.0) {
    error_rad *= kept_angle;
    fixture.ct_from_reference =
        (motion.ct_from_needle * FromRotationVector(error_rad)).normalized();
  }
  fixture.offset_mm *= kept_offset;
  fixture.angle_rad = error_rad.norm();

  const Eigen::Vector3d along = fixture.DirectionInCt();
  const Eigen::Vector3d across_mm_per_s =
      motion.velocity_mm_per_s - motion.velocity_mm_per_s.dot(along) * along;
  // The needle may be turned about itself.
  const Eigen::Vector3d turning_rad_per_s =
      motion.angular_velocity_rad_per_s - motion.angular_velocity_rad_per_s.dot(along) * along;
  FixtureForce out;
  out.trajectory_moved = kept_angle < 1.0 || kept_offset < 1.0;
  out.torque_n_mm = Limited(settings.angular_n_mm_per_rad * (motion.ct_from_needle * error_rad) -
                                settings.angular_damping_n_mm_s_per_rad * turning_rad_per_s,
                            settings.torque_limit_n_mm);
  out.force_n = Limited(-settings.lateral_n_per_mm * fixture.offset_mm -
                            settings.lateral_damping_n_s_per_mm * across_mm_per_s,
                        settings.force_limit_n);
  return out;
}

}  // namespace acus::forces
