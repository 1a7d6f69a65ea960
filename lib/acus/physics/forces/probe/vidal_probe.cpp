#include "acus/physics/forces/probe/vidal_probe.h"

#include <cmath>

namespace acus::forces {

VidalProbe::VidalProbe(const ForceTable& table, const HuField& field)
    : settings_(table.settings),
      law_(table.vidal.probe),
      field_(field),
      bone_(volume::LabelOf("bone")) {}

ProbeForce VidalProbe::Step(VidalProbeState& state, const ProbeInput& input) const noexcept {
  const Eigen::Vector3d place = input.ct_from_probe.translation();
  switch (state.Judge(input.time_s, input.valid, place, Eigen::Vector3d::UnitZ())) {
    case SampleGate::Verdict::kZero:
      return {};
    case SampleGate::Verdict::kHold: {
      ProbeForce held = state.last;
      held.force_in_ct_n *= state.HeldShare(settings_);
      return held;
    }
    case SampleGate::Verdict::kStep:
      break;
  }
  const bool first = !state.started;
  const double dt_s = first ? 1.0 : input.time_s - state.valid_time_s;
  if (first) state.place_in_ct_mm = place;
  const Eigen::Vector3d travel_mm = place - state.place_in_ct_mm;
  const Eigen::Vector3d before =
      first ? CameFrom(field_, law_.skin, place, input.ct_from_probe.linear().col(1))
            : state.place_in_ct_mm;
  MeetSkin(field_, law_.skin, state.skin, before, place);

  ProbeForce out;
  out.on_skin = state.skin.touching;
  const Eigen::Vector3d spring_n = law_.moves_proxy ? MovedProxyN(state, place, dt_s, out)
                                                    : TwoSpringsN(state, before, place, out);
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  if (out.on_skin) {
    out.skin_mm = state.skin.PenetrationMm(place).norm();
    out.num_on_skin = 1;
    if (out.on_bone) out.structure = bone_;
    force_n = ContactForceN(state.skin, spring_n, travel_mm / dt_s, law_.damping_n_s_per_mm);
  }
  const double stiffest = law_.skin_n_per_mm + law_.bone_n_per_mm + law_.damping_n_s_per_mm / dt_s;
  force_n *=
      state.rise.ShareToGive(force_n.norm(), travel_mm.norm(), dt_s, stiffest, law_.smoothing_s);
  const double size_n = force_n.norm();
  if (size_n > law_.largest_force_n) force_n *= law_.largest_force_n / size_n;
  out.force_in_ct_n = force_n;
  state.place_in_ct_mm = place;
  state.last = out;
  state.Accept(input.time_s, {});
  return out;
}

Eigen::Vector3d VidalProbe::TwoSpringsN(VidalProbeState& state, const Eigen::Vector3d& before,
                                        const Eigen::Vector3d& place,
                                        ProbeForce& out) const noexcept {
  MeetStructure(field_, law_.bone, state.skin, state.bone, before, place);
  const Eigen::Vector3d bone_mm = state.bone.PenetrationMm(place);
  out.on_bone = state.bone.touching;
  out.bone_mm = bone_mm.norm();
  return law_.skin_n_per_mm * state.skin.PenetrationMm(place) + law_.bone_n_per_mm * bone_mm;
}

/// Section 3.3.1 as printed. Where the proxy jumps, what the force would jump by is given up over
/// the time of smoothing.
Eigen::Vector3d VidalProbe::MovedProxyN(VidalProbeState& state, const Eigen::Vector3d& place,
                                        double dt_s, ProbeForce& out) const noexcept {
  if (!state.skin.touching) {
    state.moved_n = state.spring_n = Eigen::Vector3d::Zero();
    state.proxy_on_bone = false;
    return state.spring_n;
  }
  const Eigen::Vector3d skin_mm = state.skin.PenetrationMm(place);
  const double crossing = field_.FirstCrossing(state.skin.at_in_ct_mm, place, law_.bone.hu);
  out.on_bone = crossing <= 1.0;
  Eigen::Vector3d spring_n = law_.skin_n_per_mm * skin_mm;
  if (out.on_bone) {
    const Eigen::Vector3d proxy_mm = (1.0 - crossing) * skin_mm;  // From the device to it.
    out.bone_mm = proxy_mm.norm();
    spring_n = (law_.skin_n_per_mm + law_.bone_n_per_mm) * proxy_mm;
  }
  state.moved_n *= law_.smoothing_s > 0.0 ? std::exp(-dt_s / law_.smoothing_s) : 0.0;
  if (out.on_bone != state.proxy_on_bone && law_.smoothing_s > 0.0) {
    state.moved_n += state.spring_n - spring_n;
  }
  state.proxy_on_bone = out.on_bone;
  state.spring_n = spring_n;
  return spring_n + state.moved_n;
}

}  // namespace acus::forces
