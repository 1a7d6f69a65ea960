#include "forces/vidal_probe.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

constexpr double kFarthestSkinMm = 20.0;  // The skin is sought at most so far behind the probe.
constexpr double kFastestMmPerS = 500.0;  // Beyond it, it is the tracker that jumped.
constexpr double kSuddenN = 0.05;  // A rise beyond what the springs give for the way is smoothed.

}  // namespace

VidalProbe::VidalProbe(const ForceTable& table, const HuField& field)
    : settings_(table.settings), law_(table.vidal.probe), field_(field) {}

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
  MeetSkin(state, place, first);
  MeetBone(state, place);

  ProbeForce out;
  out.on_skin = state.skin.touching;
  out.on_bone = state.bone.touching;
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();
  if (out.on_skin) {
    const Eigen::Vector3d skin_mm = state.skin.PenetrationMm(place);
    const Eigen::Vector3d bone_mm = state.bone.PenetrationMm(place);
    out.skin_mm = skin_mm.norm();
    out.bone_mm = bone_mm.norm();
    const Eigen::Vector3d spring_n = law_.skin_n_per_mm * skin_mm + law_.bone_n_per_mm * bone_mm;
    Eigen::Vector3d damping_n = -law_.damping_n_s_per_mm * travel_mm / dt_s;
    const double most_n = spring_n.norm();  // A jump is not a speed.
    if (damping_n.norm() > most_n) damping_n *= most_n / damping_n.norm();
    force_n = spring_n + damping_n;
    const double outwards_n = force_n.dot(state.skin.outward_in_ct);
    if (outwards_n < 0.0) force_n -= outwards_n * state.skin.outward_in_ct;  // Skin never pulls.
  }
  force_n *= ShareToGive(state, force_n.norm(), travel_mm.norm(), dt_s);
  const double size_n = force_n.norm();
  if (size_n > law_.largest_force_n) force_n *= law_.largest_force_n / size_n;
  out.force_in_ct_n = force_n;
  state.place_in_ct_mm = place;
  state.last = out;
  state.Accept(input.time_s, {});
  return out;
}

void VidalProbe::MeetSkin(VidalProbeState& state, const Eigen::Vector3d& place,
                          bool first) const noexcept {
  if (state.skin.touching) {
    state.skin.Follow(field_, law_.skin, place);
  } else {
    const Eigen::Vector3d way = place - state.place_in_ct_mm;
    const double length_mm = way.norm();
    const double share = length_mm > kFarthestSkinMm ? kFarthestSkinMm / length_mm : 1.0;
    const Eigen::Vector3d from = first ? place : Eigen::Vector3d(place - share * way);
    const double crossing = field_.FirstCrossing(from, place, law_.skin.hu);
    if (crossing <= 1.0) {
      state.skin.outward_in_ct = length_mm > 0.0 ? Eigen::Vector3d(-way / length_mm)
                                                 : Eigen::Vector3d(Eigen::Vector3d::UnitZ());
      state.skin.Touch(field_, law_.skin, from + crossing * (place - from));
      state.skin.Follow(field_, law_.skin, place);
    }
  }
  if (!state.skin.touching) state.bone.touching = false;
}

void VidalProbe::MeetBone(VidalProbeState& state, const Eigen::Vector3d& place) const noexcept {
  if (!state.skin.touching) return;
  if (state.bone.touching) {
    state.bone.Follow(field_, law_.bone, place);
    return;
  }
  const Eigen::Vector3d line = place - state.skin.at_in_ct_mm;
  const double crossing = field_.FirstCrossing(state.skin.at_in_ct_mm, place, law_.bone.hu);
  if (crossing > 1.0) return;
  const double beyond_mm = (1.0 - crossing) * line.norm();
  const Eigen::Vector3d travel_mm = place - state.place_in_ct_mm;
  state.bone.outward_in_ct = state.skin.outward_in_ct;
  if (beyond_mm <= travel_mm.norm() + field_.ResolutionMm()) {
    state.bone.Touch(field_, law_.bone, state.skin.at_in_ct_mm + crossing * line);
  } else if (field_.HuAt(place) >= law_.bone.hu) {
    // Pushed into its side: bone pushes back from where the device came in. A device that slid
    // below a bone through soft tissue feels nothing of it: a force out of nowhere would throw it.
    const double side = field_.FirstCrossing(state.place_in_ct_mm, place, law_.bone.hu);
    state.bone.Touch(field_, law_.bone, state.place_in_ct_mm + std::min(side, 1.0) * travel_mm);
  }
  state.bone.Follow(field_, law_.bone, place);
}

/// A rise that the springs do not explain by the way made is spread over the smoothing time.
double VidalProbe::ShareToGive(VidalProbeState& state, double force_n, double travel_mm,
                               double dt_s) const noexcept {
  if (law_.smoothing_s <= 0.0) return 1.0;
  state.held_back *= std::exp(-dt_s / law_.smoothing_s);
  const double stiffest = law_.skin_n_per_mm + law_.bone_n_per_mm + law_.damping_n_s_per_mm / dt_s;
  const double rise_n = kSuddenN + 2.0 * stiffest * std::min(travel_mm, kFastestMmPerS * dt_s);
  if (force_n > state.model_n + rise_n) {
    const double before_n = (1.0 - state.held_back) * state.model_n;
    state.held_back = 1.0 - before_n / force_n;
  }
  state.model_n = force_n;
  return 1.0 - state.held_back;
}

}  // namespace acus::forces
