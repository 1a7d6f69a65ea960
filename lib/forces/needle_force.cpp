#include "forces/needle_force.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

constexpr double kFarthestMm = 1e5;          // Coordinates beyond it are not positions in a room.
constexpr double kLargestFirstStepMm = 5.0;  // The skin is sought at most so far behind the tip.
constexpr double kEscapeMm = 20.0;           // Off the path by this and outside the body: it left.
constexpr double kSkinTremorMm = 1.0;
constexpr double kShallowMm = 2.0;    // Here a path is moved, deeper it turns at the skin.
constexpr double kDrawnBackMm = 2.0;  // Shorter pull-backs are not the start of a redirect.
constexpr double kFadeShare = 0.5;    // Of the redirect depth, in which resistance fades.
constexpr double kLockMm = 0.5;       // Advance that ends a redirect.
constexpr double kBoneReleaseMm = 0.1;
constexpr double kBoneSlipMm = 1.0;       // Sideways shift after which the tip may slide off.
constexpr double kShortestFreeMm = 10.0;  // The hand's end of the beam never gets shorter.

}  // namespace

/// One valid sample together with the one before.
struct NeedleForceModel::Motion {
  double dt_s = 0.0;
  Eigen::Vector3d previous_mm;
  Eigen::Vector3d tip_mm;
  Eigen::Vector3d axis;
  volume::Label previous_label = 0;
  volume::Label label = 0;
  bool has_previous = false;
};

struct NeedleForceModel::Membrane {
  const PuncturePolynomial* law = nullptr;  ///< Null: the tip presses on none.
  double at_mm = 0.0;
};

std::string_view NameOf(NeedleEvent event) noexcept {
  constexpr std::string_view kNames[] = {"none",         "contact",      "puncture",  "interface",
                                         "bone_contact", "bone_release", "withdrawal"};
  return kNames[static_cast<std::size_t>(event)];
}

NeedleForceModel::NeedleForceModel(const ForceTable& table, const NeedleProperties& needle)
    : table_(table.ScaledTo(needle.beam.outer_diameter_mm)), needle_(needle) {}

NeedleForce NeedleForceModel::Step(NeedleForceState& state,
                                   const NeedleInput& input) const noexcept {
  if (!std::isfinite(input.time_s)) {
    ++state.num_rejected;
    return {};
  }
  if (state.started && input.time_s <= state.time_s) {
    ++state.num_time_back;
    return HeldForce(state);
  }
  state.time_s = input.time_s;
  if (!input.valid) return state.started ? HeldForce(state) : NeedleForce{};

  const double axis_length = input.axis_in_ct.norm();
  if (!(axis_length > 1e-9 && axis_length < 1e9) ||
      !(input.tip_in_ct_mm.cwiseAbs().maxCoeff() <= kFarthestMm) ||
      !input.tip_in_ct_mm.allFinite()) {
    ++state.num_rejected;
    return {};
  }
  Motion motion;
  motion.has_previous = state.started;
  motion.dt_s = state.started ? input.time_s - state.valid_time_s : 1.0;
  motion.previous_mm = state.started ? state.tip_in_ct_mm : input.tip_in_ct_mm;
  motion.previous_label = state.tissue_at_tip;
  motion.tip_mm = input.tip_in_ct_mm;
  motion.axis = input.axis_in_ct / axis_length;
  motion.label = input.tissue_at_tip;

  NeedleForce out;
  const bool touched = !state.in_body && motion.label != 0;
  if (touched) TouchSkin(state, motion);
  if (state.in_body) out = InBody(state, motion, touched);

  state.started = true;
  state.valid_time_s = input.time_s;
  state.tip_in_ct_mm = motion.tip_mm;
  state.tissue_at_tip = motion.label;
  state.held = out;
  return out;
}

NeedleForce NeedleForceModel::HeldForce(const NeedleForceState& state) const noexcept {
  const double late_s = state.time_s - state.valid_time_s - table_.settings.invalid_hold_s;
  const double ramp_s = table_.settings.invalid_ramp_s;
  const double share = late_s <= 0.0 ? 1.0 : (late_s < ramp_s ? 1.0 - late_s / ramp_s : 0.0);
  NeedleForce out = state.held;
  out.puncture_n *= share;
  out.cutting_n *= share;
  out.friction_n *= share;
  out.bone_n *= share;
  out.lateral_n *= share;
  out.force_in_ct_n *= share;
  out.event = NeedleEvent::kNone;
  return out;
}

void NeedleForceModel::TouchSkin(NeedleForceState& state, const Motion& motion) const noexcept {
  // The skin is somewhere between the last sample outside and this one: half way, on average.
  const bool came_from_outside = motion.has_previous && motion.previous_label == 0;
  const double advance_mm = (motion.tip_mm - motion.previous_mm).dot(motion.axis);
  const double inside_mm =
      came_from_outside ? std::clamp(0.5 * advance_mm, 0.0, kLargestFirstStepMm) : 0.0;
  state.in_body = true;
  state.path = NeedlePath();
  state.path.entry_in_ct_mm = motion.tip_mm - inside_mm * motion.axis;
  state.path.direction_in_ct = motion.axis;
  state.path.Append(motion.label, table_.tissue[motion.label].friction_n_per_mm);
  state.pressing = HasMembrane(0, motion.label);
  state.membrane_mm = 0.0;
  state.membrane_of = motion.label;
  state.pierced = !state.pressing;
  state.device_mm = state.depth_mm = state.channel_mm = 0.0;
  state.cut_tissue = motion.label;
  state.wall = {};
  state.bristle = {};
  state.has_candidate = state.on_bone = state.redirecting = state.seen_outside = false;
}

NeedleForce NeedleForceModel::InBody(NeedleForceState& state, const Motion& motion,
                                     bool touched) const noexcept {
  NeedleForce out;
  Guide(state, motion);
  if (HasLeft(state, motion)) {
    out.event = state.pierced ? NeedleEvent::kWithdrawal : NeedleEvent::kNone;
    state.in_body = false;
    return out;
  }
  const double previous_mm = state.depth_mm;
  const double previous_device_mm = state.device_mm;
  const double device_mm = state.path.DepthMm(motion.tip_mm);
  const NeedleEvent at_bone = MeetBone(state, motion, device_mm);
  state.device_mm = device_mm;
  state.depth_mm = state.on_bone ? std::min(device_mm, state.bone_mm) : device_mm;
  const NeedleEvent at_tissue = MeetTissue(state, motion.label, previous_mm);

  if (state.on_bone) {
    const double speed_mm_per_s = (device_mm - previous_device_mm) / motion.dt_s;
    out.bone_penetration_mm = std::max(0.0, device_mm - state.bone_mm);
    out.bone_n = table_.settings.bone.ForceN(out.bone_penetration_mm, speed_mm_per_s);
  }
  const bool was_pierced = state.pierced;
  const bool punctured = TryPuncture(state, motion, out.bone_n);
  if (was_pierced) {  // A shaft that has just come in has not slid yet.
    state.bristle.Slide(state.depth_mm - previous_mm, table_.settings.friction_buildup_mm);
  }
  Redirect(state, motion);
  TipForces(state, out);
  Finish(state, motion, out);

  // The last that applies counts.
  out.event = at_bone;
  if (at_tissue != NeedleEvent::kNone) out.event = at_tissue;
  if (touched) out.event = NeedleEvent::kContact;
  if (punctured) out.event = NeedleEvent::kPuncture;
  if (at_bone == NeedleEvent::kBoneContact) out.event = at_bone;
  return out;
}

/// True if the needle is no longer in or on the body.
bool NeedleForceModel::HasLeft(NeedleForceState& state, const Motion& motion) const noexcept {
  // A hand that rests the tip on the skin trembles: that is one contact, not many.
  const double slack_mm =
      std::max(table_.settings.interface_hysteresis_mm, state.pierced ? 0.05 : kSkinTremorMm);
  if (state.path.DepthMm(motion.tip_mm) < -slack_mm) return true;
  if (motion.label != 0) {
    state.seen_outside = false;
    return false;
  }
  if (state.pierced) return state.path.DeviationMm(motion.tip_mm).norm() > kEscapeMm;
  // Unpierced and off the skin: slid off, unless the label only flickers.
  if (!state.seen_outside) state.outside_at_mm = motion.tip_mm;
  state.seen_outside = true;
  return (motion.tip_mm - state.outside_at_mm).norm() >= slack_mm;
}

/// Turns the path where the tissue gives way to the lateral force.
void NeedleForceModel::Guide(NeedleForceState& state, const Motion& motion) const noexcept {
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

/// A needle drawn back to near the skin may be turned freely; it starts a new path.
void NeedleForceModel::Redirect(NeedleForceState& state, const Motion& motion) const noexcept {
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
    state.pressing = state.has_candidate = false;
  }
}

NeedleEvent NeedleForceModel::MeetBone(NeedleForceState& state, const Motion& motion,
                                       double device_mm) const noexcept {
  const bool is_bone = table_.tissue[motion.label].impenetrable;
  const Eigen::Vector3d deviation_mm = state.path.DeviationMm(motion.tip_mm);
  if (!state.on_bone) {
    if (!is_bone) return NeedleEvent::kNone;
    state.on_bone = true;
    state.bone_mm = 0.5 * (device_mm + std::min(device_mm, state.device_mm));
    state.bone_first_mm = state.bone_mm;
    state.bone_deviation_mm = deviation_mm;
    return NeedleEvent::kBoneContact;
  }
  const double beyond_mm = device_mm - state.bone_mm;
  const double grazing_mm = table_.settings.interface_hysteresis_mm;
  bool released = beyond_mm < -kBoneReleaseMm;
  if (!is_bone && beyond_mm > 0.0) {
    // A device pressed right through a thin bone is still held by it. One that shifted sideways, or
    // that only just met a stray voxel, is let go little by little, so that the force cannot jump.
    const bool slipped = (deviation_mm - state.bone_deviation_mm).norm() > kBoneSlipMm;
    if (slipped || beyond_mm < grazing_mm) {
      state.bone_mm += std::min(beyond_mm, 2.0 * (motion.tip_mm - motion.previous_mm).norm());
    }
    released = state.bone_mm - state.bone_first_mm > grazing_mm && state.bone_mm >= device_mm;
  }
  if (!released) return NeedleEvent::kNone;
  state.on_bone = false;
  return NeedleEvent::kBoneRelease;
}

/// Follows the tissues along the path. In the channel that is cut already there is nothing to meet.
NeedleEvent NeedleForceModel::MeetTissue(NeedleForceState& state, volume::Label label,
                                         double previous_mm) const noexcept {
  NeedlePath& path = state.path;
  const double depth_mm = state.depth_mm;
  const double hysteresis_mm = table_.settings.interface_hysteresis_mm;
  if (state.pressing && state.pierced && depth_mm < state.membrane_mm - hysteresis_mm) {
    state.pressing = state.has_candidate = false;  // Drawn back from an inner membrane.
    path.CutOffAt(state.membrane_mm);
  }
  if (depth_mm <= path.EndMm()) {
    state.has_candidate = false;
    return NeedleEvent::kNone;
  }
  if (state.on_bone) return NeedleEvent::kNone;  // The device's tip is elsewhere.
  if (label == path.LastTissue()) {
    state.has_candidate = false;
    path.ExtendTo(depth_mm);
    return NeedleEvent::kNone;
  }
  if (!state.has_candidate || state.candidate != label) {
    state.has_candidate = true;
    state.candidate = label;
    state.candidate_mm = std::max(path.EndMm(), 0.5 * (std::min(previous_mm, depth_mm) + depth_mm));
  }
  if (depth_mm - state.candidate_mm < hysteresis_mm) return NeedleEvent::kNone;

  const bool membrane = !state.pressing && HasMembrane(path.LastTissue(), label);
  path.ExtendTo(state.candidate_mm);
  path.Append(label, table_.tissue[label].friction_n_per_mm);
  path.ExtendTo(depth_mm);
  state.has_candidate = false;
  if (membrane) {
    state.pressing = true;
    state.membrane_mm = state.candidate_mm;
    state.membrane_of = label;
  } else if (!state.pressing) {
    state.cut_tissue = label;
  }
  return NeedleEvent::kInterface;
}

bool NeedleForceModel::HasMembrane(volume::Label from, volume::Label to) const noexcept {
  const TissueForce& tissue = table_.tissue[to];
  return tissue.membrane.puncture_n > 0.0 && !tissue.no_membrane_from.test(from);
}

/// The membrane that is pressed on; also one that was seen too shortly to be certain, so that its
/// force begins at zero.
NeedleForceModel::Membrane NeedleForceModel::ActiveMembrane(
    const NeedleForceState& state) const noexcept {
  if (state.pressing) return {&table_.tissue[state.membrane_of].membrane, state.membrane_mm};
  if (state.has_candidate && HasMembrane(state.path.LastTissue(), state.candidate)) {
    return {&table_.tissue[state.candidate].membrane, state.candidate_mm};
  }
  return {};
}

bool NeedleForceModel::TryPuncture(NeedleForceState& state, const Motion& motion,
                                   double bone_n) const noexcept {
  if (!state.pressing) return false;
  const PuncturePolynomial& law = table_.tissue[state.membrane_of].membrane;
  const double pressed_n = law.ForceN(state.depth_mm - state.membrane_mm) + bone_n;
  if (pressed_n < law.puncture_n) return false;
  state.pressing = false;
  state.cut_tissue = state.path.LastTissue();
  state.channel_mm = std::max(state.channel_mm, state.depth_mm);
  // The tissue springs back over the tip, which from now on cuts; never with more force than
  // before.
  const double cutting_n = std::min(table_.tissue[state.cut_tissue].cutting_n, pressed_n);
  state.wall.wall_mm = state.depth_mm - cutting_n / table_.settings.cutting_stiffness_n_per_mm;
  if (!state.pierced) {
    state.pierced = true;
    state.path.direction_in_ct = motion.axis;  // Locked on piercing (Augmented-2010, II.D).
    state.path.entry_in_ct_mm = motion.tip_mm - state.device_mm * motion.axis;
  }
  return true;
}

void NeedleForceModel::TipForces(NeedleForceState& state, NeedleForce& out) const noexcept {
  const Membrane membrane = ActiveMembrane(state);
  double buried_mm = state.depth_mm;
  if (membrane.law != nullptr) buried_mm = std::min(buried_mm, membrane.at_mm);
  if (state.pierced) {
    state.channel_mm = std::max(state.channel_mm, buried_mm);
    out.cutting_n = state.wall.Advance(state.depth_mm, table_.tissue[state.cut_tissue].cutting_n,
                                       table_.settings.cutting_stiffness_n_per_mm);
    out.friction_n = state.path.FrictionN(std::min(buried_mm, needle_.length_mm)) *
                     state.bristle.Slide(0.0, table_.settings.friction_buildup_mm);
  }
  if (membrane.law != nullptr) {
    // The larger of the two acts: the tip leaves the tissue before only when it presses harder.
    const double pressed_n = membrane.law->ForceN(state.depth_mm - membrane.at_mm);
    out.puncture_n = std::max(0.0, pressed_n - out.cutting_n);
  }
}

void NeedleForceModel::Finish(const NeedleForceState& state, const Motion& motion,
                              NeedleForce& out) const noexcept {
  out.depth_mm = state.depth_mm;
  out.force_in_ct_n = -out.AxialN() * state.path.direction_in_ct;
  if (state.pierced) {
    const Eigen::Vector3d deviation_mm = state.path.DeviationMm(motion.tip_mm);
    const double size_mm = deviation_mm.norm();
    out.lateral_n =
        std::min(LateralStiffnessNPerMm(state.depth_mm) * size_mm, table_.settings.lateral_limit_n);
    if (size_mm > 0.0) out.force_in_ct_n -= (out.lateral_n / size_mm) * deviation_mm;
  }
  const double size_n = out.force_in_ct_n.norm();
  if (size_n <= table_.settings.largest_force_n) return;
  const double share = table_.settings.largest_force_n / size_n;
  out.puncture_n *= share;
  out.cutting_n *= share;
  out.friction_n *= share;
  out.bone_n *= share;
  out.lateral_n *= share;
  out.force_in_ct_n *= share;
}

double NeedleForceModel::LateralStiffnessNPerMm(double depth_mm) const noexcept {
  const double buried_mm = std::clamp(depth_mm, 0.0, needle_.length_mm);
  // The shaft turns about the skin, so its deviation grows linearly to the tip: a force at the tip
  // with the same moment is a third of what it would be if all of the shaft were displaced.
  const double tissue = table_.settings.tissue_lateral_stiffness_n_per_mm2 * buried_mm / 3.0;
  const double free_mm = std::max(needle_.length_mm - buried_mm, kShortestFreeMm);
  const double beam = needle_.beam.EndStiffnessNPerMm(free_mm);
  return tissue > 0.0 ? beam * tissue / (beam + tissue) : 0.0;
}

}  // namespace acus::forces
