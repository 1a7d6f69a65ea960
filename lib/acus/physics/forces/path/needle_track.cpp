#include "acus/physics/forces/path/needle_track.h"

#include <algorithm>

namespace acus::forces {
namespace {

constexpr double kLargestFirstStepMm = 5.0;  // The skin is sought at most so far behind the tip.
constexpr double kEscapeMm = 20.0;           // Off the path by this and outside the body: it left.
constexpr double kSkinTremorMm = 1.0;
constexpr double kBoneReleaseMm = 0.1;
constexpr double kBoneSlipMm = 1.0;  // Sideways shift after which the tip may slide off.

}  // namespace

NeedleMotion MotionOf(const NeedleTrack& track, const NeedleInput& input) noexcept {
  NeedleMotion motion;
  motion.has_previous = track.started;
  motion.dt_s = track.started ? input.time_s - track.valid_time_s : 1.0;
  motion.previous_mm = track.started ? track.tip_in_ct_mm : input.tip_in_ct_mm;
  motion.previous_label = track.tissue_at_tip;
  motion.tip_mm = input.tip_in_ct_mm;
  motion.axis = input.axis_in_ct / input.axis_in_ct.norm();
  motion.label = input.tissue_at_tip;
  return motion;
}

void TouchSkin(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion) noexcept {
  // The skin is somewhere between the last sample outside and this one: half way, on average.
  const bool came_from_outside = motion.has_previous && motion.previous_label == 0;
  const double advance_mm = (motion.tip_mm - motion.previous_mm).dot(motion.axis);
  const double inside_mm =
      came_from_outside ? std::clamp(0.5 * advance_mm, 0.0, kLargestFirstStepMm) : 0.0;
  track.in_body = true;
  track.path = NeedlePath();
  track.path.entry_in_ct_mm = motion.tip_mm - inside_mm * motion.axis;
  track.path.direction_in_ct = motion.axis;
  track.path.Append(motion.label, table.tissue[motion.label].friction_n_per_mm,
                    table.tissue[motion.label].withdrawal_friction_n_per_mm);
  track.pressing =
      table.HasMembrane(0, motion.label) && !table.nick.Contains(track.path.entry_in_ct_mm);
  track.membrane_mm = 0.0;
  track.membrane_of = motion.label;
  track.pierced = !track.pressing;
  track.device_mm = track.depth_mm = track.channel_mm = 0.0;
  track.cut_tissue = track.around_tip = motion.label;
  track.has_candidate = track.on_bone = track.seen_outside = false;
}

bool HasLeft(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion) noexcept {
  // A hand that rests the tip on the skin trembles: that is one contact, not many.
  const double slack_mm =
      std::max(table.settings.interface_hysteresis_mm, track.pierced ? 0.05 : kSkinTremorMm);
  if (track.path.DepthMm(motion.tip_mm) < -slack_mm) return true;
  if (motion.label != 0) {
    track.seen_outside = false;
    return false;
  }
  if (track.pierced) return track.path.DeviationMm(motion.tip_mm).norm() > kEscapeMm;
  // Unpierced and off the skin: slid off, unless the label only flickers.
  if (!track.seen_outside) track.outside_at_mm = motion.tip_mm;
  track.seen_outside = true;
  return (motion.tip_mm - track.outside_at_mm).norm() >= slack_mm;
}

NeedleEvent MeetBone(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion,
                     double device_mm) noexcept {
  const bool is_bone = table.tissue[motion.label].impenetrable;
  const Eigen::Vector3d deviation_mm = track.path.DeviationMm(motion.tip_mm);
  if (!track.on_bone) {
    if (!is_bone) return NeedleEvent::kNone;
    track.on_bone = true;
    track.bone_mm = 0.5 * (device_mm + std::min(device_mm, track.device_mm));
    track.bone_first_mm = track.bone_mm;
    track.bone_deviation_mm = deviation_mm;
    return NeedleEvent::kBoneContact;
  }
  const double beyond_mm = device_mm - track.bone_mm;
  const double grazing_mm = table.settings.interface_hysteresis_mm;
  bool released = beyond_mm < -kBoneReleaseMm;
  if (!is_bone && beyond_mm > 0.0) {
    // A device pressed right through a thin bone is still held by it. One that shifted sideways, or
    // that only just met a stray voxel, is let go little by little, so that the force cannot jump.
    const bool slipped = (deviation_mm - track.bone_deviation_mm).norm() > kBoneSlipMm;
    if (slipped || beyond_mm < grazing_mm) {
      track.bone_mm += std::min(beyond_mm, 2.0 * (motion.tip_mm - motion.previous_mm).norm());
    }
    released = track.bone_mm - track.bone_first_mm > grazing_mm && track.bone_mm >= device_mm;
  }
  if (!released) return NeedleEvent::kNone;
  track.on_bone = false;
  return NeedleEvent::kBoneRelease;
}

NeedleEvent MeetTissue(const ForceTable& table, NeedleTrack& track, volume::Label label,
                       double previous_mm) noexcept {
  NeedlePath& path = track.path;
  const double depth_mm = track.depth_mm;
  const double hysteresis_mm = table.settings.interface_hysteresis_mm;
  if (track.pressing && track.pierced && depth_mm < track.membrane_mm - hysteresis_mm) {
    track.pressing = track.has_candidate = false;  // Withdrawn from an inner membrane.
    path.CutOffAt(track.membrane_mm);
  }
  if (depth_mm <= path.EndMm()) {
    track.has_candidate = false;
    return NeedleEvent::kNone;
  }
  if (track.on_bone) return NeedleEvent::kNone;  // The device's tip is elsewhere.
  if (label == path.LastTissue()) {
    track.has_candidate = false;
    path.ExtendTo(depth_mm);
    return NeedleEvent::kNone;
  }
  if (!track.has_candidate || track.candidate != label) {
    track.has_candidate = true;
    track.candidate = label;
    track.candidate_mm = std::max(path.EndMm(), 0.5 * (std::min(previous_mm, depth_mm) + depth_mm));
  }
  if (depth_mm - track.candidate_mm < hysteresis_mm) return NeedleEvent::kNone;

  const bool membrane = !track.pressing && table.HasMembrane(path.LastTissue(), label);
  path.ExtendTo(track.candidate_mm);
  path.Append(label, table.tissue[label].friction_n_per_mm,
              table.tissue[label].withdrawal_friction_n_per_mm);
  path.ExtendTo(depth_mm);
  track.has_candidate = false;
  if (membrane) {
    track.pressing = true;
    track.membrane_mm = track.candidate_mm;
    track.membrane_of = label;
  } else if (!track.pressing) {
    track.cut_tissue = label;
  }
  return NeedleEvent::kInterface;
}

PressedMembrane ActiveMembrane(const ForceTable& table, const NeedleTrack& track) noexcept {
  if (track.pressing) return {track.membrane_of, track.membrane_mm};
  if (track.has_candidate && table.HasMembrane(track.path.LastTissue(), track.candidate)) {
    return {track.candidate, track.candidate_mm};
  }
  return {};
}

void CreepMembrane(const ForceTable& table, NeedleTrack& track, const TipMove& move) noexcept {
  const PressedMembrane membrane = ActiveMembrane(table, track);
  const ForceRelaxation& relaxation = table.tissue[membrane.tissue].time.relaxation;
  if (track.creeping != membrane) {
    track.creeping = membrane;
    track.crept_mm.fill(membrane.at_mm);
  }
  for (int k = 0; k < relaxation.num_terms; ++k) {
    track.crept_mm[k] = CreptMm(track.crept_mm[k], move, membrane.at_mm, relaxation.time_s[k]);
  }
}

double PressedN(const ForceTable& table, const NeedleTrack& track) noexcept {
  const PressedMembrane membrane = ActiveMembrane(table, track);
  if (membrane.tissue == 0) return 0.0;
  const TissueForce& tissue = table.tissue[membrane.tissue];
  const ForceRelaxation& relaxation = tissue.time.relaxation;
  double force_n = tissue.membrane.ForceN(track.depth_mm - membrane.at_mm);
  if (relaxation.num_terms == 0) return force_n;
  force_n *= relaxation.ElasticShare();
  for (int k = 0; k < relaxation.num_terms; ++k) {
    force_n += relaxation.share[k] * tissue.membrane.ForceN(track.depth_mm - track.crept_mm[k]);
  }
  return force_n;
}

double TryPuncture(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion,
                   double bone_n) noexcept {
  if (!track.pressing) return 0.0;
  const PuncturePolynomial& law = table.tissue[track.membrane_of].membrane;
  const double pressed_n = PressedN(table, track) + bone_n;
  if (pressed_n < law.puncture_n) return 0.0;
  track.pressing = false;
  track.cut_tissue = track.path.LastTissue();
  track.channel_mm = std::max(track.channel_mm, track.depth_mm);
  if (!track.pierced) {
    track.pierced = true;
    track.path.direction_in_ct = motion.axis;  // Locked on piercing (Augmented-2010, II.D).
    track.path.entry_in_ct_mm = motion.tip_mm - track.device_mm * motion.axis;
  }
  return pressed_n;
}

volume::Label TissueAroundTip(const NeedleTrack& track, volume::Label before,
                              double hysteresis_mm) noexcept {
  if (track.pressing) return track.cut_tissue;
  const volume::Label above = track.path.TissueAt(track.depth_mm - hysteresis_mm);
  const volume::Label below = track.path.TissueAt(track.depth_mm + hysteresis_mm);
  return above == below ? above : before;
}

namespace {

/// Passing from tissue to tissue in the channel is distinguished from cutting into one for the
/// first time, which is the event that the step has already.
NeedleEvent PassInChannel(const ForceTable& table, NeedleTrack& track,
                          const TrackStep& step) noexcept {
  const volume::Label before = track.around_tip;
  if (step.punctured_n > 0.0 || (step.event == NeedleEvent::kInterface && !track.pressing)) {
    track.around_tip = track.cut_tissue;
    return NeedleEvent::kNone;
  }
  track.around_tip = TissueAroundTip(track, before, table.settings.interface_hysteresis_mm);
  const bool is_cut = track.depth_mm < track.path.EndMm();
  return is_cut && track.around_tip != before ? NeedleEvent::kChannelInterface : NeedleEvent::kNone;
}

}  // namespace

TrackStep FollowPath(const ForceTable& table, NeedleTrack& track, const NeedleMotion& motion,
                     bool touched) noexcept {
  TrackStep step;
  step.was_pierced = track.pierced;
  step.left = HasLeft(table, track, motion);
  if (step.left) {
    step.event = track.pierced ? NeedleEvent::kWithdrawal : NeedleEvent::kNone;
    track.in_body = false;
    return step;
  }
  step.previous_mm = track.depth_mm;
  const double previous_device_mm = track.device_mm;
  const double device_mm = track.path.DepthMm(motion.tip_mm);
  step.event = MeetBone(table, track, motion, device_mm);
  track.device_mm = device_mm;
  track.depth_mm = track.on_bone ? std::min(device_mm, track.bone_mm) : device_mm;
  step.event = FirstOf(step.event, MeetTissue(table, track, motion.label, step.previous_mm));
  step.device_speed_mm_per_s = (device_mm - previous_device_mm) / motion.dt_s;
  if (track.on_bone) {
    step.bone_penetration_mm = std::max(0.0, device_mm - track.bone_mm);
    step.bone_n = table.settings.bone.ForceN(step.bone_penetration_mm, step.device_speed_mm_per_s);
  }
  CreepMembrane(table, track, {step.previous_mm, track.depth_mm, motion.dt_s});
  step.punctured_n = TryPuncture(table, track, motion, step.bone_n);
  step.event = FirstOf(step.event, PassInChannel(table, track, step));
  if (touched) step.event = FirstOf(step.event, NeedleEvent::kContact);
  if (step.punctured_n > 0.0) step.event = FirstOf(step.event, NeedleEvent::kPuncture);
  return step;
}

}  // namespace acus::forces
