#include "acus/physics/forces/probe/multi_proxy_probe.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::forces {
namespace {

/// Place of a pose: its translation, or something that no sample gate lets pass unless it is rigid.
Eigen::Vector3d PlaceOf(const Eigen::Isometry3d& pose) noexcept {
  const Eigen::Matrix3d turn = pose.linear();
  const double off = (turn.transpose() * turn - Eigen::Matrix3d::Identity()).norm();
  if (off < 0.1) return pose.translation();  // NaN is not.
  return Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

/// From the device back to its proxy, growing more than in proportion with the way: the gradient of
/// a potential that only depends on its length.
Eigen::Vector3d RepulsionN(const MultiProxySettings::Repulsion& law,
                           const Eigen::Vector3d& way_mm) noexcept {
  return (law.a1_n_per_mm + law.a2_n_per_mm2 * way_mm.norm()) * way_mm;
}

double SlopeNPerMm(const MultiProxySettings::Repulsion& law, double way_mm) noexcept {
  return law.a1_n_per_mm + 2.0 * law.a2_n_per_mm2 * way_mm;
}

}  // namespace

/// One node of the tool in one step.
struct MultiProxyProbe::Touch {
  Eigen::Vector3d before_mm;
  Eigen::Vector3d place_mm;
  double dt_s = 1.0;
  Eigen::Vector3d sought_from_mm;  ///< Where the skin is sought from: before_mm, if there was one.
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  ///< If all of the tool were this node.
  double structure_n = 0.0;                           ///< Of the strongest structure.
  int structure = -1;
};

MultiProxyProbe::MultiProxyProbe(const ForceTable& table, const PalpationTool& tool,
                                 PalpationFields fields)
    : settings_(table.settings),
      law_(table.multi_proxy),
      tool_(tool),
      fields_(std::move(fields)),
      skin_{fields_.skin_value, law_.skin.friction, law_.face_mm},
      bone_(volume::LabelOf("bone")) {
  ACUS_REQUIRE(fields_.structures.size() <= MultiProxySettings::kMostStructures, "there are ",
               fields_.structures.size(), " structures to feel under the skin; at most ",
               MultiProxySettings::kMostStructures);
  for (const auto& structure : fields_.structures) {
    structures_.push_back({structure.value, structure.law.repulsion.friction, 0.5 * law_.face_mm});
  }
}

ProbeForce MultiProxyProbe::Step(MultiProxyState& state, const ProbeInput& input) const noexcept {
  const Eigen::Isometry3d& pose = input.ct_from_probe;
  switch (state.Judge(input.time_s, input.valid, PlaceOf(pose), Eigen::Vector3d::UnitZ())) {
    case SampleGate::Verdict::kZero:
      return {};
    case SampleGate::Verdict::kHold: {
      ProbeForce held = state.last;
      held.force_in_ct_n *= state.HeldShare(settings_);
      held.torque_in_ct_n_mm *= state.HeldShare(settings_);
      return held;
    }
    case SampleGate::Verdict::kStep:
      break;
  }
  Touch touch;
  const bool first = !state.started;
  touch.dt_s = first ? 1.0 : input.time_s - state.valid_time_s;
  if (first) state.ct_from_tool = pose;

  ProbeForce out;
  double travel_mm = 0.0;
  double strongest_n = 0.0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(tool_.num_nodes); ++i) {
    MultiProxyState::Node& node = state.node[i];
    touch.before_mm = state.ct_from_tool * tool_.node_mm[i];
    touch.place_mm = pose * tool_.node_mm[i];
    touch.sought_from_mm =
        first ? CameFrom(*fields_.skin, skin_, touch.place_mm, pose.linear().col(1))
              : touch.before_mm;
    travel_mm = std::max(travel_mm, (touch.place_mm - touch.before_mm).norm());
    StepNode(node, touch);
    if (!node.skin.touching) continue;
    ++out.num_on_skin;
    out.skin_mm = std::max(out.skin_mm, node.skin.PenetrationMm(touch.place_mm).norm());
    out.force_in_ct_n += touch.force_n;
    out.torque_in_ct_n_mm += (touch.place_mm - pose.translation()).cross(touch.force_n);
    for (std::size_t k = 0; k < structures_.size(); ++k) {
      if (fields_.structures[k].law.tissue != bone_ || !node.structure[k].touching) continue;
      out.on_bone = true;
      out.bone_mm = std::max(out.bone_mm, node.structure[k].PenetrationMm(touch.place_mm).norm());
    }
    if (touch.structure >= 0 && touch.structure_n >= strongest_n) {
      strongest_n = touch.structure_n;
      out.structure = fields_.structures[static_cast<std::size_t>(touch.structure)].law.tissue;
    }
  }
  out.on_skin = out.num_on_skin > 0;
  const double size_n = out.force_in_ct_n.norm() / tool_.num_nodes;
  double share = state.rise.ShareToGive(size_n, travel_mm, touch.dt_s,
                                        StiffestNPerMm(out) + law_.damping_n_s_per_mm / touch.dt_s,
                                        law_.smoothing_s);
  if (share * size_n > law_.largest_force_n) share = law_.largest_force_n / size_n;
  out.force_in_ct_n *= share / tool_.num_nodes;
  out.torque_in_ct_n_mm *= share / tool_.num_nodes;
  state.ct_from_tool = pose;
  state.last = out;
  state.Accept(input.time_s, {});
  return out;
}

void MultiProxyProbe::StepNode(MultiProxyState::Node& node, Touch& touch) const noexcept {
  const Eigen::Vector3d& place = touch.place_mm;
  MeetSkin(*fields_.skin, skin_, node.skin, touch.sought_from_mm, place);
  touch.structure = -1;
  touch.structure_n = 0.0;
  if (!node.skin.touching) {
    for (SurfaceProxy& proxy : node.structure) proxy.touching = false;
    return;
  }
  Eigen::Vector3d spring_n = RepulsionN(law_.skin, node.skin.PenetrationMm(place));
  for (std::size_t k = 0; k < structures_.size(); ++k) {
    const PalpationFields::Structure& structure = fields_.structures[k];
    SurfaceProxy& proxy = node.structure[k];
    MeetStructure(*structure.field, structures_[k], node.skin, proxy, touch.sought_from_mm, place);
    if (!proxy.touching) continue;
    const Eigen::Vector3d pushes_n =
        RepulsionN(structure.law.repulsion, proxy.PenetrationMm(place));
    spring_n += pushes_n;
    const double pushes_by_n = pushes_n.norm();
    if (touch.structure < 0 || pushes_by_n > touch.structure_n) {
      touch.structure = static_cast<int>(k);
      touch.structure_n = pushes_by_n;
    }
  }
  touch.force_n = ContactForceN(node.skin, spring_n, (place - touch.before_mm) / touch.dt_s,
                                law_.damping_n_s_per_mm);
}

double MultiProxyProbe::StiffestNPerMm(const ProbeForce& force) const noexcept {
  double sum = SlopeNPerMm(law_.skin, force.skin_mm);
  for (const auto& structure : fields_.structures) {
    sum += SlopeNPerMm(structure.law.repulsion, force.skin_mm);
  }
  return sum;
}

}  // namespace acus::forces
