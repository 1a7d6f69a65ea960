#include "acus/physics/forces/models/needle_force.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

constexpr double kShallowMm = 2.0;        // Here a path is moved, deeper it turns at the skin.
constexpr double kDrawnBackMm = 2.0;      // Shorter pull-backs are not the start of a redirect.
constexpr double kFadeShare = 0.5;        // Of the redirect depth, in which resistance fades.
constexpr double kLockMm = 0.5;           // Advance that ends a redirect.
constexpr double kShortestFreeMm = 10.0;  // The hand's end of the beam never gets shorter.

}  // namespace

double LateralStiffnessNPerMm(const NeedleProperties& needle, const ForceSettings& settings,
                              double depth_mm) noexcept {
  const double buried_mm = std::clamp(depth_mm, 0.0, needle.length_mm);
  // The shaft turns about the skin, so its deviation grows linearly to the tip: a force at the tip
  // with the same moment is a third of what it would be if all of the shaft were displaced.
  const double tissue = settings.tissue_lateral_stiffness_n_per_mm2 * buried_mm / 3.0;
  const double free_mm = std::max(needle.length_mm - buried_mm, kShortestFreeMm);
  const double beam = needle.beam.EndStiffnessNPerMm(free_mm);
  return tissue > 0.0 ? beam * tissue / (beam + tissue) : 0.0;
}

NeedleForceModel::NeedleForceModel(const ForceTable& table, const NeedleProperties& needle,
                                   GuidanceKind guidance)
    : table_(table.ScaledTo(needle.beam.outer_diameter_mm)),
      needle_(needle),
      guidance_(guidance),
      shaft_(table_),
      grip_(table_) {}

NeedleForce NeedleForceModel::Step(NeedleForceState& state,
                                   const NeedleInput& input) const noexcept {
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
    state.walls_of = 0;
    state.walls_n = 0.0;
    state.crept_wall_mm.fill(0.0);
    state.bristle = {};
    state.shaft = {};
    state.redirecting = false;
    state.guide = {};
  }
  if (!state.started || touched) state.guide.axis_in_ct = motion.axis;
  if (state.in_body) out = InBody(state, motion, touched);
  state.guide.axis_in_ct = motion.axis;
  state.tip_in_ct_mm = motion.tip_mm;
  state.tissue_at_tip = motion.label;
  state.Accept(input.time_s, out);
  return out;
}

NeedleForce NeedleForceModel::InBody(NeedleForceState& state, const NeedleMotion& motion,
                                     bool touched) const noexcept {
  NeedleForce out;
  if (guidance_ == GuidanceKind::kOwn) Guide(state, motion);
  if (state.pierced) TurnPath(guidance_, table_, state, motion);
  const TrackStep step = FollowPath(table_, state, motion, touched);
  out.event = step.event;
  if (step.left) return out;
  out.bone_penetration_mm = step.bone_penetration_mm;
  out.bone_n = step.bone_n;
  if (step.punctured_n > 0.0) {
    // The tissue springs back over the tip, which from now on cuts; never with more force than
    // before.
    const double cutting_n = std::min(table_.tissue[state.cut_tissue].cutting_n, step.punctured_n);
    state.wall.wall_mm = state.depth_mm - cutting_n / table_.settings.cutting_stiffness_n_per_mm;
    state.crept_wall_mm.fill(state.wall.wall_mm);
    state.walls_of = state.cut_tissue;
  }
  if (step.was_pierced) {
    const double travel_mm = state.depth_mm - step.previous_mm;
    if (table_.HasTime()) {
      shaft_.Slide(state.shaft, travel_mm, motion.dt_s);
    } else {
      state.bristle.Slide(travel_mm, table_.settings.friction_buildup_mm);
    }
  }
  // Guidance that decides where the needle may turn does so itself.
  if (guidance_ == GuidanceKind::kOwn || guidance_ == GuidanceKind::kNone) Redirect(state, motion);
  TipForces(state, {step.previous_mm, state.depth_mm, motion.dt_s}, out);
  Finish(state, motion, step.was_pierced, out);
  return out;
}

/// Turns the path where the tissue yields to the lateral force.
void NeedleForceModel::Guide(NeedleForceState& state, const NeedleMotion& motion) const noexcept {
  if (!state.pierced) return;
  NeedlePath& path = state.path;
  const Eigen::Vector3d deviation_mm = path.DeviationMm(motion.tip_mm);
  const double depth_mm = path.DepthMm(motion.tip_mm);
  double limit_n = table_.settings.lateral_limit_n;
  if (state.redirecting) {
    const double free_mm = table_.settings.redirect_depth_mm;
    limit_n *= std::clamp((depth_mm - free_mm) / (kFadeShare * free_mm), 0.0, 1.0);
  }
  const double stiffness = LateralStiffnessNPerMm(depth_mm);
  const double size_mm = deviation_mm.norm();
  if (stiffness * size_mm <= limit_n || size_mm < 1e-12) return;
  const Eigen::Vector3d kept_mm = deviation_mm * (limit_n / (stiffness * size_mm));
  if (depth_mm < kShallowMm) {
    path.entry_in_ct_mm += deviation_mm - kept_mm;
  } else {
    path.direction_in_ct = (motion.tip_mm - kept_mm - path.entry_in_ct_mm).normalized();
  }
  if (state.redirecting) {  // What lies ahead on the turned path is not cut yet.
    state.path.CutOffAt(depth_mm);
    state.channel_mm = std::clamp(depth_mm, 0.0, state.channel_mm);
  }
}

/// A needle withdrawn to near the skin may be turned freely; it starts a new path.
void NeedleForceModel::Redirect(NeedleForceState& state,
                                const NeedleMotion& motion) const noexcept {
  const double redirect_mm = table_.settings.redirect_depth_mm;
  const double depth_mm = state.depth_mm;
  if (!state.pierced || state.on_bone || redirect_mm <= 0.0) return;
  const double fade_mm = (1.0 + kFadeShare) * redirect_mm;  // Resistance fades from here on.
  if (!state.redirecting && depth_mm < fade_mm && state.channel_mm - depth_mm > kDrawnBackMm) {
    state.redirecting = true;
    state.lowest_mm = depth_mm;
  }
  if (!state.redirecting) return;
  state.lowest_mm = std::min(state.lowest_mm, depth_mm);
  if (depth_mm > state.lowest_mm + kLockMm || depth_mm >= fade_mm) {
    state.redirecting = false;
  } else if (depth_mm < redirect_mm) {
    state.path.direction_in_ct = motion.axis;
    state.path.entry_in_ct_mm = motion.tip_mm - state.device_mm * motion.axis;
    state.path.CutOffAt(depth_mm);
    state.channel_mm = std::max(0.0, depth_mm);
    state.cut_tissue = state.path.LastTissue();
    state.wall.wall_mm = depth_mm;
    state.crept_wall_mm.fill(depth_mm);
    state.pressing = state.has_candidate = false;
  }
}

void NeedleForceModel::TipForces(NeedleForceState& state, const TipMove& move,
                                 NeedleForce& out) const noexcept {
  const PressedMembrane membrane = ActiveMembrane(table_, state);
  double buried_mm = state.depth_mm;
  if (membrane.tissue != 0) buried_mm = std::min(buried_mm, membrane.at_mm);
  if (state.pierced) {
    state.channel_mm = std::max(state.channel_mm, buried_mm);
    out.cutting_n = CuttingN(state, move);
    out.friction_n = FrictionN(state, std::min(buried_mm, needle_.length_mm));
  }
  // The larger of the two acts: the tip leaves the tissue before only when it presses harder.
  out.puncture_n = std::max(0.0, PressedN(table_, state) - out.cutting_n);
}

double NeedleForceModel::CuttingN(NeedleForceState& state, const TipMove& move) const noexcept {
  const TissueForce& tissue = table_.tissue[state.cut_tissue];
  const double stiffness = table_.settings.cutting_stiffness_n_per_mm;
  if (!table_.HasTime()) return state.wall.Advance(state.depth_mm, tissue.cutting_n, stiffness);
  if (state.walls_of != state.cut_tissue) {
    // Springs of the same mean length hold the same force and store no more.
    const double length_mm = state.walls_n / stiffness;
    if (length_mm > 0.0) state.wall.wall_mm = move.from_mm - length_mm;
    state.crept_wall_mm.fill(state.wall.wall_mm);
    state.walls_of = state.cut_tissue;
  }
  const ForceRelaxation& relaxation = tissue.time.relaxation;
  const double home_mm = state.wall.wall_mm;
  const double elastic_n = state.wall.Advance(move.to_mm, tissue.cutting_n, stiffness);
  state.walls_n = relaxation.ElasticShare() * elastic_n;
  for (int k = 0; k < relaxation.num_terms; ++k) {
    TrackingWall crept{CreptMm(state.crept_wall_mm[k], move, home_mm, relaxation.time_s[k])};
    state.walls_n += relaxation.share[k] * crept.Advance(move.to_mm, tissue.cutting_n, stiffness);
    state.crept_wall_mm[k] = crept.wall_mm;
  }
  return state.walls_n;
}

double NeedleForceModel::FrictionN(NeedleForceState& state, double shaft_mm) const noexcept {
  if (table_.HasTime()) return shaft_.ForceN(state.shaft, state.path, shaft_mm);
  const double share = state.bristle.Slide(0.0, table_.settings.friction_buildup_mm);
  // Each sign has its own spring of bristles, and both begin at 0: no energy comes of it.
  if (share >= 0.0) return share * state.path.FrictionN(shaft_mm);
  return share * (state.path.WithdrawalFrictionN(shaft_mm) +
                  grip_.SumN(state.path, shaft_mm, [](volume::Label) { return 1.0; }));
}

void NeedleForceModel::Finish(NeedleForceState& state, const NeedleMotion& motion, bool was_pierced,
                              NeedleForce& out) const noexcept {
  out.depth_mm = state.depth_mm;
  out.force_in_ct_n = -out.AxialN() * state.path.direction_in_ct;
  if (state.pierced && guidance_ != GuidanceKind::kOwn) {
    const GuidanceForce guided =
        GuideNeedle(guidance_, table_, state.guide, state, motion, was_pierced);
    out.lateral_n = guided.force_n.norm();
    out.force_in_ct_n += guided.force_n;
    out.torque_in_ct_n_mm = guided.torque_n_mm;
  } else if (state.pierced) {
    const Eigen::Vector3d deviation_mm = state.path.DeviationMm(motion.tip_mm);
    const double size_mm = deviation_mm.norm();
    out.lateral_n =
        std::min(LateralStiffnessNPerMm(state.depth_mm) * size_mm, table_.settings.lateral_limit_n);
    if (size_mm > 0.0) out.force_in_ct_n -= (out.lateral_n / size_mm) * deviation_mm;
  }
  LimitTo(out, table_.settings.largest_force_n);
}

}  // namespace acus::forces
