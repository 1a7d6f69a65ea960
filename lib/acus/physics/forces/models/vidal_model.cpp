#include "acus/physics/forces/models/vidal_model.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

constexpr double kFarthestSkinMm = 5.0;  // The skin is sought at most so far behind the tip.
constexpr double kEdgeHysteresis = 0.8;  // An interface ends below this share of its threshold.
constexpr double kNoResistance = 1e-9;   // N s/mm.

}  // namespace

VidalModel::VidalModel(const ForceTable& table, const NeedleProperties& needle,
                       const HuField& field, GuidanceKind guidance)
    : table_(table.ScaledTo(needle.beam.outer_diameter_mm)),
      field_(field),
      guidance_(guidance == GuidanceKind::kOwn ? GuidanceKind::kVidal : guidance),
      bone_(volume::LabelOf("bone")) {
  table_.tissue[bone_].impenetrable = true;  // Here bone is what the CT says is bone.
}

NeedleForce VidalModel::Step(VidalState& state, const NeedleInput& input) const noexcept {
  const auto verdict = state.Judge(input);
  if (verdict != SampleGate::Verdict::kStep) {
    return state.ForceInstead(verdict, table_.settings);
  }
  NeedleMotion motion = MotionOf(state, input);
  NeedleForce out;
  const bool touched = !state.in_body && MeetSkin(state, motion);
  if (state.in_body) out = state.pierced ? InTissue(state, motion) : OnSkin(state, motion);
  if (touched) out.event = FirstOf(out.event, NeedleEvent::kContact);
  out.force_in_ct_n += table_.vidal.gravity_in_ct_n;
  LimitTo(out, table_.settings.largest_force_n);
  state.guide.axis_in_ct = motion.axis;
  state.tip_in_ct_mm = motion.tip_mm;
  state.tissue_at_tip = motion.label;
  state.Accept(input.time_s, out);
  return out;
}

int VidalModel::KindAt(const Eigen::Vector3d& place_in_ct_mm, int before) const noexcept {
  constexpr int kEdge = 4;
  const double hu = field_.HuAt(place_in_ct_mm);
  if (hu < table_.vidal.skin.hu) return 0;
  const bool was_edge = (before & kEdge) != 0;
  const double threshold = table_.vidal.edge_hu_per_mm * (was_edge ? kEdgeHysteresis : 1.0);
  const double gradient_squared = field_.GradientHuPerMm(place_in_ct_mm).squaredNorm();
  return (hu >= table_.vidal.bone_hu ? 2 : 1) +
         (gradient_squared >= threshold * threshold ? kEdge : 0);
}

bool VidalModel::MeetSkin(VidalState& state, const NeedleMotion& motion) const noexcept {
  const double hu = table_.vidal.skin.hu;
  const Eigen::Vector3d way = motion.tip_mm - motion.previous_mm;
  const double length_mm = way.norm();
  // After a jump the skin is sought only on the last stretch.
  const double share = length_mm > kFarthestSkinMm ? kFarthestSkinMm / length_mm : 1.0;
  const Eigen::Vector3d from = motion.tip_mm - share * way;
  const double crossing = field_.FirstCrossing(from, motion.tip_mm, hu);
  if (crossing > 1.0) return false;
  const auto gate = static_cast<const SampleGate&>(state);
  state = VidalState();
  static_cast<SampleGate&>(state) = gate;
  state.in_body = true;
  state.skin.outward_in_ct = -motion.axis;
  state.skin.Touch(field_, table_.vidal.skin, from + crossing * (motion.tip_mm - from));
  return true;
}

/// Section 3.3.2: the proxy explores the skin until the force passes the threshold.
NeedleForce VidalModel::OnSkin(VidalState& state, const NeedleMotion& motion) const noexcept {
  NeedleForce out;
  state.skin.Follow(field_, table_.vidal.skin, motion.tip_mm);
  if (!state.skin.touching) {
    state.in_body = false;
    return out;
  }
  const Eigen::Vector3d pressed_mm = state.skin.PenetrationMm(motion.tip_mm);
  out.force_in_ct_n = table_.vidal.skin_n_per_mm * pressed_mm;
  out.depth_mm = state.device_mm = state.depth_mm = pressed_mm.norm();
  if (out.force_in_ct_n.norm() >= table_.vidal.puncture_n ||
      table_.nick.Contains(state.skin.at_in_ct_mm)) {
    state.pierced = true;
    state.path.entry_in_ct_mm = state.skin.at_in_ct_mm;
    state.path.direction_in_ct = motion.axis;
    state.device_mm = state.depth_mm = state.path.DepthMm(motion.tip_mm);
    out = {};
    out.depth_mm = state.depth_mm;
    out.event = NeedleEvent::kPuncture;
    return out;
  }
  out.puncture_n = -out.force_in_ct_n.dot(motion.axis);
  out.lateral_n = (out.force_in_ct_n + out.puncture_n * motion.axis).norm();
  return out;
}

NeedleForce VidalModel::InTissue(VidalState& state, NeedleMotion& motion) const noexcept {
  NeedleForce out;
  const double hu = field_.HuAt(motion.tip_mm);
  // What MeetBone and HasLeft go by.
  const volume::Label tissue = 1;
  motion.label = hu >= table_.vidal.bone_hu ? bone_ : (hu >= table_.vidal.skin.hu ? tissue : 0);
  if (HasLeft(table_, state, motion)) {
    out.event = NeedleEvent::kWithdrawal;
    state.in_body = state.pierced = false;
    return out;
  }
  TurnPath(guidance_, table_, state, motion);
  const double device_mm = state.path.DepthMm(motion.tip_mm);
  const double speed_mm_per_s = (device_mm - state.device_mm) / motion.dt_s;
  out.event = MeetBone(table_, state, motion, device_mm);
  state.device_mm = device_mm;
  state.depth_mm = state.on_bone ? std::min(device_mm, state.bone_mm) : device_mm;
  out.event = FirstOf(out.event, SeeEdge(state, motion.tip_mm));
  if (state.on_bone) {
    out.bone_penetration_mm = std::max(0.0, device_mm - state.bone_mm);
    out.bone_n = table_.settings.bone.ForceN(out.bone_penetration_mm, speed_mm_per_s);
  }
  out.depth_mm = state.depth_mm;
  Resistance(state, motion, hu, out);
  const GuidanceForce guided = GuideNeedle(guidance_, table_, state.guide, state, motion, true);
  out.force_in_ct_n += guided.force_n;
  out.torque_in_ct_n_mm = guided.torque_n_mm;
  const Eigen::Vector3d& along = state.path.direction_in_ct;
  out.lateral_n = (out.force_in_ct_n - out.force_in_ct_n.dot(along) * along).norm();
  return out;
}

NeedleEvent VidalModel::SeeEdge(VidalState& state, const Eigen::Vector3d& tip_mm) const noexcept {
  if (state.on_bone) return NeedleEvent::kNone;
  const double threshold = table_.vidal.edge_hu_per_mm;
  const double gradient = field_.GradientHuPerMm(tip_mm).norm();
  const bool before = state.at_edge;
  state.at_edge = gradient >= (before ? kEdgeHysteresis * threshold : threshold);
  const bool is_cut = state.depth_mm < state.channel_mm;
  state.channel_mm = std::max(state.channel_mm, state.depth_mm);
  if (!state.at_edge || before) return NeedleEvent::kNone;
  return is_cut ? NeedleEvent::kChannelInterface : NeedleEvent::kInterface;
}

/// F1, eq. 2 to 7: a resistance to speed, averaged.
void VidalModel::Resistance(VidalState& state, const NeedleMotion& motion, double hu,
                            NeedleForce& out) const noexcept {
  const VidalSettings& law = table_.vidal;
  const Eigen::Vector3d& along = state.path.direction_in_ct;
  Eigen::Vector3d velocity_mm_per_s = (motion.tip_mm - motion.previous_mm) / motion.dt_s;
  double resistance = law.resistance_n_s_per_mm(hu) * (state.at_edge ? law.edge_factor : 1.0);
  if (velocity_mm_per_s.dot(along) < 0.0) resistance = law.withdrawal_n_s_per_mm;
  if (state.on_bone) velocity_mm_per_s.setZero();  // The tip stays.

  if (!law.passive_average) {  // As printed: also the force of bone is averaged.
    const Eigen::Vector3d sub_force = -resistance * velocity_mm_per_s - out.bone_n * along;
    state.resistance_in_ct_n =
        state.resistance_mean.AddAsPrinted(sub_force, motion.dt_s, law.averaging_s);
    const double bone_n = out.bone_n;
    out.bone_n = 0.0;
    if (bone_n > 0.0) out.bone_n = std::max(0.0, -state.resistance_in_ct_n.dot(along));
  } else if (resistance < kNoResistance) {
    state.resistance_in_ct_n.setZero();
    state.resistance_n_per_mm = 0.0;
  } else {
    // A mean that fades over tau is a damper in series with a spring of resistance / tau.
    const double stiffness =
        std::min(law.largest_n_per_mm, resistance / std::max(1e-6, 0.5 * law.averaging_s));
    if (stiffness < state.resistance_n_per_mm) {  // The stored energy must not rise.
      state.resistance_in_ct_n *= std::sqrt(stiffness / state.resistance_n_per_mm);
    }
    state.resistance_n_per_mm = stiffness;
    const Eigen::Vector3d steady_n = -resistance * velocity_mm_per_s;
    const double left = std::exp(-stiffness * motion.dt_s / resistance);
    state.resistance_in_ct_n = steady_n + (state.resistance_in_ct_n - steady_n) * left;
    const double size_n = state.resistance_in_ct_n.norm();
    const double largest_n = table_.settings.largest_force_n;
    if (size_n > largest_n) state.resistance_in_ct_n *= largest_n / size_n;
  }
  const Eigen::Vector3d& force_n = state.resistance_in_ct_n;
  const double axial_n = law.passive_average || out.bone_n == 0.0 ? -force_n.dot(along) : 0.0;
  (axial_n > 0.0 ? out.cutting_n : out.friction_n) = axial_n;
  out.force_in_ct_n = force_n - force_n.dot(along) * along - out.AxialN() * along;
}

}  // namespace acus::forces
