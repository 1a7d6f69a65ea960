#include "acus/physics/forces/path/guidance.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

constexpr double kPlayMm = 0.5;   // Going back and forth by less is not an advance.
constexpr double kPivotMm = 0.5;  // Less deep a line through skin and tip has no direction.

/// Turns the path towards the needle's axis as far as that brings it nearer to the tip: the tissue
/// near the skin lets a needle be turned, and a line that moves to the needle gives it no energy.
void Turn(NeedlePath& path, const NeedleMotion& motion) noexcept {
  const Eigen::Vector3d from = path.direction_in_ct;
  const Eigen::Vector3d across = motion.axis - motion.axis.dot(from) * from;
  const double size = across.norm();
  if (size < 1e-12) return;
  const Eigen::Vector3d aside = across / size;
  const Eigen::Vector3d to_tip = motion.tip_mm - path.entry_in_ct_mm;
  const double axis_rad = std::atan2(size, motion.axis.dot(from));
  const double tip_rad = std::atan2(to_tip.dot(aside), to_tip.dot(from));
  const double turn_rad = std::clamp(tip_rad, 0.0, axis_rad);
  if (turn_rad <= 0.0) return;
  path.direction_in_ct = (std::cos(turn_rad) * from + std::sin(turn_rad) * aside).normalized();
}

/// F2, eq. 8. The mean comes late by half its window, and a late spring gives energy: a damping of
/// its stiffness times that time takes just as much. As printed there is neither this damping nor a
/// limit.
Eigen::Vector3d LineForceN(const ForceTable& table, WindowAverage& offset_mean,
                           const NeedlePath& path, const NeedleMotion& motion) noexcept {
  const VidalSettings& law = table.vidal;
  const Eigen::Vector3d offset_mm = path.DeviationMm(motion.tip_mm);
  const Eigen::Vector3d mean_mm =
      !law.passive_average
          ? offset_mean.AddAsPrinted(offset_mm, motion.dt_s, law.guidance_averaging_s)
          : offset_mean.Add(offset_mm, motion.dt_s, law.guidance_averaging_s);
  const Eigen::Vector3d wanted_n = -law.guidance_n_per_mm * mean_mm;
  const double share = wanted_n.norm() / law.guidance_clamp_n;
  const double gauss = std::exp(-0.5 * share * share);
  if (!law.passive_average) return (1.0 - gauss) * wanted_n;
  const double slope = 1.0 - gauss + share * share * gauss;  // d(K2 F) / dF.
  const Eigen::Vector3d& along = path.direction_in_ct;
  const Eigen::Vector3d travel_mm = motion.tip_mm - motion.previous_mm;
  const Eigen::Vector3d across_mm_per_s = (travel_mm - travel_mm.dot(along) * along) / motion.dt_s;
  const double damping = slope * law.guidance_n_per_mm * 0.5 * law.guidance_averaging_s;
  Eigen::Vector3d force_n = (1.0 - gauss) * wanted_n - damping * across_mm_per_s;
  const double size_n = force_n.norm();
  const double limit_n = table.settings.lateral_limit_n;
  if (size_n > limit_n) force_n *= limit_n / size_n;
  return force_n;
}

GuidanceForce Clamp(const ForceTable& table, GuidanceState& state, NeedleTrack& track,
                    const NeedleMotion& motion, bool was_pierced) noexcept {
  if (!state.holds) {  // Eq. 7: q0 is stored as it pierces.
    state.holds = true;
    state.fixture = {};
    state.fixture.ct_from_reference =
        WithoutTwist(Eigen::Quaterniond::Identity(), track.path.direction_in_ct);
    state.play_mm = track.depth_mm;
  }
  FixtureMotion move;
  move.ct_from_needle = WithoutTwist(state.fixture.ct_from_reference, motion.axis);
  move.offset_mm = track.path.DeviationMm(motion.tip_mm);
  const double dt_s = motion.dt_s;
  move.velocity_mm_per_s = (motion.tip_mm - motion.previous_mm) / dt_s;
  const Eigen::Vector3d cross = state.axis_in_ct.cross(motion.axis);
  const double sine = cross.norm();
  const double angle_rad = std::atan2(sine, state.axis_in_ct.dot(motion.axis));
  if (sine > 0.0) move.angular_velocity_rad_per_s = cross * (angle_rad / (sine * dt_s));
  const double play_before_mm = state.play_mm;
  state.play_mm = std::clamp(state.play_mm, track.depth_mm - kPlayMm, track.depth_mm);
  if (was_pierced) move.advance_mm = std::max(0.0, state.play_mm - play_before_mm);

  const FixtureForce clamping = StepFixture(table.alamilla.clamping, state.fixture, move);
  if (clamping.trajectory_moved) {  // The needle's depth stays.
    const Eigen::Vector3d direction = state.fixture.DirectionInCt();
    const Eigen::Vector3d offset_mm =
        state.fixture.offset_mm - state.fixture.offset_mm.dot(direction) * direction;
    track.path.direction_in_ct = direction;
    track.path.entry_in_ct_mm = motion.tip_mm - offset_mm - track.device_mm * direction;
  }
  return {clamping.force_n, clamping.torque_n_mm};
}

}  // namespace

void TurnPath(GuidanceKind kind, const ForceTable& table, NeedleTrack& track,
              const NeedleMotion& motion) noexcept {
  if (kind != GuidanceKind::kVidal) return;
  const double device_mm = track.path.DepthMm(motion.tip_mm);
  if (device_mm > kPivotMm && device_mm < table.vidal.orientation_depth_mm) {
    Turn(track.path, motion);
  }
}

GuidanceForce GuideNeedle(GuidanceKind kind, const ForceTable& table, GuidanceState& state,
                          NeedleTrack& track, const NeedleMotion& motion,
                          bool was_pierced) noexcept {
  switch (kind) {
    case GuidanceKind::kVidal:
      return {LineForceN(table, state.offset_mean, track.path, motion), Eigen::Vector3d::Zero()};
    case GuidanceKind::kVirtualFixture:
      return Clamp(table, state, track, motion, was_pierced);
    case GuidanceKind::kOwn:
    case GuidanceKind::kNone:
      break;
  }
  return {};
}

}  // namespace acus::forces
