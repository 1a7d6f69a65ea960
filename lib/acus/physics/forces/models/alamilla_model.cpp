#include "acus/physics/forces/models/alamilla_model.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {

AlamillaModel::AlamillaModel(const ForceTable& table, const NeedleProperties& needle,
                             GuidanceKind guidance)
    : table_(table.ScaledTo(needle.beam.outer_diameter_mm)),
      guidance_(guidance == GuidanceKind::kOwn ? GuidanceKind::kVirtualFixture : guidance) {}

NeedleForce AlamillaModel::Step(AlamillaState& state, const NeedleInput& input) const noexcept {
  const auto verdict = state.Judge(input);
  if (verdict != SampleGate::Verdict::kStep) {
    return state.ForceInstead(verdict, table_.settings);
  }
  const NeedleMotion motion = MotionOf(state, input);
  NeedleForce out;
  const bool touched = !state.in_body && motion.label != 0;
  if (touched) {
    TouchSkin(table_, state, motion);
    state.wall = {};
    state.wall_n = state.wall_n_per_mm = 0.0;
    state.friction = {};
    state.knock.Stop();
    state.guide = {};
    state.held_by = 0;
  }
  if (!state.started || touched) state.guide.axis_in_ct = motion.axis;
  if (state.in_body) out = InBody(state, motion, touched);
  state.guide.axis_in_ct = motion.axis;
  state.tip_in_ct_mm = motion.tip_mm;
  state.tissue_at_tip = motion.label;
  state.Accept(input.time_s, out);
  return out;
}

NeedleForce AlamillaModel::InBody(AlamillaState& state, const NeedleMotion& motion,
                                  bool touched) const noexcept {
  NeedleForce out;
  if (state.pierced) TurnPath(guidance_, table_, state, motion);
  const TrackStep step = FollowPath(table_, state, motion, touched);
  out.event = step.event;
  if (step.left) return out;
  if (state.pierced && (touched || !step.was_pierced)) {
    state.wall.wall_mm = state.depth_mm;  // Eq. 2: the force drops to 0, then the wall builds up.
    state.held_by = state.cut_tissue;
  }
  AlongThePath(state, motion, step, out);
  const bool clamps = !(state.on_bone && table_.alamilla.only_bone_on_bone);
  if (!clamps) out.puncture_n = out.cutting_n = out.friction_n = 0.0;
  out.force_in_ct_n = -out.AxialN() * state.path.direction_in_ct;
  if (state.pierced && clamps) {
    const GuidanceForce guided =
        GuideNeedle(guidance_, table_, state.guide, state, motion, step.was_pierced);
    out.lateral_n = guided.force_n.norm();
    out.force_in_ct_n += guided.force_n;
    out.torque_in_ct_n_mm = guided.torque_n_mm;
  }
  out.depth_mm = state.depth_mm;
  LimitTo(out, table_.settings.largest_force_n);
  return out;
}

/// Eq. 3, in both directions. A stiffer tissue takes the force over as it is; in a softer one the
/// spring keeps its length: neither gives energy.
double AlamillaModel::WallN(AlamillaState& state, double previous_mm) const noexcept {
  const TissueForce& tissue = table_.tissue[state.held_by];
  if (table_.alamilla.direct_method) {
    return state.wall_n = DirectMethodN(state.depth_mm, tissue.cutting_n);
  }
  const double own = tissue.cutting_stiffness_n_per_mm;
  const double stiffness = own > 0.0 ? own : table_.settings.cutting_stiffness_n_per_mm;
  if (stiffness > state.wall_n_per_mm && state.wall_n_per_mm > 0.0) {
    state.wall.wall_mm = previous_mm - state.wall_n / stiffness;
  }
  state.wall_n_per_mm = stiffness;
  state.wall_n =
      state.wall.AdvanceBothWays(state.depth_mm, tissue.cutting_n,
                                 table_.alamilla.withdrawal_share * tissue.cutting_n, stiffness);
  return state.wall_n;
}

void AlamillaModel::AlongThePath(AlamillaState& state, const NeedleMotion& motion,
                                 const TrackStep& step, NeedleForce& out) const noexcept {
  if (state.pierced) {
    state.held_by = TissueAroundTip(state, state.held_by, table_.settings.interface_hysteresis_mm);
    out.cutting_n = WallN(state, step.previous_mm);
    const double travel_mm = step.was_pierced ? state.depth_mm - step.previous_mm : 0.0;
    out.friction_n = state.friction.Advance(table_.alamilla.friction, travel_mm, motion.dt_s,
                                            table_.tissue[state.held_by].cutting_n);
    state.channel_mm = std::max(state.channel_mm, state.depth_mm);
  }
  // The larger of the two acts: the tip leaves the tissue before only when it presses harder.
  out.puncture_n = std::max(0.0, PressedN(table_, state) - std::max(0.0, out.cutting_n));
  const HardContactSettings& knock = table_.alamilla.hard_contact;
  if (step.event == NeedleEvent::kBoneContact) {
    const double impact_mm_per_s =
        state.pierced ? state.friction.filtered_mm_per_s : step.device_speed_mm_per_s;
    state.knock.Strike(knock, impact_mm_per_s);
  }
  if (!state.on_bone) state.knock.Stop();
  const double spring_n = table_.alamilla.only_bone_on_bone ? 0.0 : step.bone_n;
  out.bone_n =
      spring_n + state.knock.Advance(knock, step.device_speed_mm_per_s * motion.dt_s, motion.dt_s,
                                     spring_n, table_.settings.bone.largest_n);
  out.bone_penetration_mm = step.bone_penetration_mm;
}

}  // namespace acus::forces
