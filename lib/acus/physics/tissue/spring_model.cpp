#include "acus/physics/tissue/spring_model.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/physics/tissue/shaft_springs.h"

namespace acus::tissue {
namespace {

using forces::NeedleEvent;

constexpr int kSpringMostSubsteps = 512;  // Of the tip in one step: half a spacing each.
constexpr double kSpringSlackMm = 0.05;   // Off the skin by this: it left.
constexpr double kSpringTremorMm = 1.0;   // The same before the skin is pierced.
constexpr double kSpringEscapeMm = 20.0;  // Off the path by this and outside the body: it left.
constexpr double kSpringLookMm = 0.1;     // Between looks at the tissue on the tip's way.
constexpr double kSpringTinyMm = 1e-9;
constexpr int kSpringBisections = 30;

/// No branch is longer than friction of steady sliding holds it.
void HoldOffsets(PathNode& node) {
  const auto held = [&](double offset_mm) {
    return FrictionOffsetMm(offset_mm, 0.0, node.axial_n_per_mm, node.friction_n);
  };
  node.offset_mm = held(node.offset_mm);
  for (double& offset_mm : node.relaxing_mm) offset_mm = held(offset_mm);
}

/// Last place, going from a to b, whose label is that of a.
template <typename SameAsA>
Eigen::Vector3d BoundaryMm(Eigen::Vector3d a, Eigen::Vector3d b, const SameAsA& same) {
  for (int i = 0; i < kSpringBisections; ++i) {
    const Eigen::Vector3d middle = 0.5 * (a + b);
    (same(middle) ? a : b) = middle;
  }
  return 0.5 * (a + b);
}

}  // namespace

double TipAdvanceMm(double ahead_mm, double a1_n_per_mm, double a2_n_per_mm2,
                    double cutting_n) noexcept {
  if (ahead_mm <= 0.0) return ahead_mm;
  if ((a2_n_per_mm2 * ahead_mm + a1_n_per_mm) * ahead_mm < cutting_n) return 0.0;
  if (a2_n_per_mm2 > 0.0) {
    const double gamma_1 = 0.5 * a1_n_per_mm / a2_n_per_mm2;
    const double gamma_2 = cutting_n / a2_n_per_mm2;
    return ahead_mm + gamma_1 - std::sqrt(gamma_1 * gamma_1 + gamma_2);
  }
  // The paper's gamma_2 divides by a2, which is 0 here; it is a1 that makes the spring hold f_cut.
  return a1_n_per_mm > 0.0 ? ahead_mm - cutting_n / a1_n_per_mm : 0.0;
}

double FrictionOffsetMm(double offset_mm, double travel_mm, double stiffness_n_per_mm,
                        double friction_n) noexcept {
  if (!(stiffness_n_per_mm > 0.0)) return 0.0;
  const double limit_mm = friction_n / stiffness_n_per_mm;
  return std::clamp(offset_mm + travel_mm, -limit_mm, limit_mm);
}

SpringModel::SpringModel(const SpringSettings& settings, const forces::ForceTable& forces,
                         const forces::NeedleProperties& needle,
                         const mechanics::ElasticityTable& elasticity,
                         const std::bitset<256>& tissues, TissueAt tissue_at, HuAt hu_at)
    : settings_(settings),
      table_(forces.ScaledTo(needle.beam.outer_diameter_mm)),
      node_of_(256),
      tissue_at_(std::move(tissue_at)),
      hu_at_(table_.hu_springs.rows.empty() ? HuAt() : std::move(hu_at)) {
  ACUS_REQUIRE(settings.node_spacing_mm > 0.0 && std::isfinite(settings.node_spacing_mm),
               "node_spacing_mm is ", settings.node_spacing_mm, "; allowed: above 0");
  ACUS_REQUIRE(settings.friction_rate_n_per_s > 0.0, "friction_rate_n_per_s is ",
               settings.friction_rate_n_per_s, "; allowed: above 0");
  const double needle_mm = 0.5 * needle.beam.outer_diameter_mm;
  const double outer_mm = settings.influence_radius_mm;
  ACUS_REQUIRE(outer_mm > 2.0 * needle_mm && std::isfinite(outer_mm), "influence_radius_mm is ",
               outer_mm, "; allowed: more than the needle's diameter, ", 2.0 * needle_mm, " mm");
  ACUS_ASSERT(tissue_at_ != nullptr);
  const ShaftStiffness shaft = ShaftInCylinder(needle_mm, outer_mm);
  for (int label = 0; label < 256; ++label) {
    PathNode& node = node_of_[label];
    const auto tissue = static_cast<volume::Label>(label);
    node.tissue = tissue;
    node.a1_n_per_mm = table_.tissue[label].cutting_a1_n_per_mm;
    node.a2_n_per_mm2 = table_.tissue[label].cutting_a2_n_per_mm2;
    if (node.a1_n_per_mm == 0.0 && node.a2_n_per_mm2 == 0.0) {
      node.a1_n_per_mm = table_.settings.cutting_stiffness_n_per_mm;
    }
    node.cutting_n = table_.tissue[label].cutting_n;
    if (label == 0 || !tissues.test(label) || table_.tissue[label].impenetrable) continue;
    const double per_mm = elasticity.At(tissue).ShearModulusMpa() * settings.node_spacing_mm;
    const forces::TissueForce& row = table_.tissue[label];
    node.axial_n_per_mm = row.shaft_n_per_mm2 > 0.0
                              ? row.shaft_n_per_mm2 * settings_.node_spacing_mm
                              : shaft.along * per_mm;
    node.lateral_n_per_mm = shaft.across * per_mm;
    node.friction_n = table_.tissue[label].friction_n_per_mm * settings.node_spacing_mm;
  }
}

forces::NeedleForce SpringModel::Step(SpringState& state, const ToolSample& sample) const noexcept {
  const auto verdict = state.gate.Judge(sample);
  if (verdict != SampleGate::Verdict::kStep) {
    return state.gate.ForceInstead(verdict, table_.settings);
  }
  const bool started = state.gate.started;
  const double dt_s = started ? sample.time_s - state.gate.valid_time_s : 1.0;
  const Eigen::Vector3d before_mm = started ? state.device_in_ct_mm : sample.tip_in_ct_mm;
  const double ahead_before_mm = state.ahead_mm;
  const bool was_outside = started && state.tissue_at_tip == 0;
  state.device_in_ct_mm = sample.tip_in_ct_mm;
  state.axis_in_ct = sample.axis_in_ct.normalized();
  const double direction_norm = sample.tip_direction_in_ct.norm();
  state.bends = direction_norm > 0.5 && direction_norm < 2.0;
  state.tip_direction_in_ct =
      state.bends ? Eigen::Vector3d(sample.tip_direction_in_ct / direction_norm) : state.axis_in_ct;
  state.tissue_at_tip = tissue_at_(state.device_in_ct_mm);

  NeedleEvent event = NeedleEvent::kNone;
  if (state.num_nodes == 0 && state.tissue_at_tip != 0) {
    Touch(state, before_mm, was_outside);
    event = NeedleEvent::kContact;
  } else if (state.num_nodes > 0) {
    DragShaft(state, (state.device_in_ct_mm - before_mm).dot(state.axis_in_ct), dt_s);
  }
  if (state.num_nodes > 0) {
    if (table_.HasTime()) CreepTip(state, state.ahead_mm, dt_s);
    const bool was_on_bone = state.on_bone;
    event = FirstOf(event, Advance(state));
    if (was_on_bone && !state.on_bone) event = FirstOf(event, NeedleEvent::kBoneRelease);
  }
  state.force = {};
  if (state.num_nodes > 0 && HasLeft(state)) {
    event = state.pierced ? NeedleEvent::kWithdrawal : NeedleEvent::kNone;
    state.num_nodes = 0;
    state.pierced = state.pressing = state.on_bone = false;
    state.ahead_mm = state.friction_n = 0.0;
  }
  if (state.num_nodes > 0) Forces(state, dt_s, ahead_before_mm);
  LimitTo(state.force, table_.settings.largest_force_n);
  state.force.event = event;
  state.gate.Accept(sample, state.force);
  return state.force;
}

/// Eq. 5, at most the cutting force.
double SpringModel::CuttingN(const PathNode& tip, double ahead_mm) noexcept {
  return std::min((tip.a2_n_per_mm2 * ahead_mm + tip.a1_n_per_mm) * ahead_mm, tip.cutting_n);
}

/// How far the device is ahead of a tip that cuts.
double SpringModel::CuttingAheadMm(const PathNode& tip) noexcept {
  if (!(tip.a2_n_per_mm2 > 0.0)) return tip.cutting_n / tip.a1_n_per_mm;
  const double gamma_1 = 0.5 * tip.a1_n_per_mm / tip.a2_n_per_mm2;
  return std::sqrt(gamma_1 * gamma_1 + tip.cutting_n / tip.a2_n_per_mm2) - gamma_1;
}

/// What a law of the indentation gives for the elastic branch and those that relax, together.
template <class Law>
double SpringModel::TipN(const SpringState& state, double ahead_mm, const Law& law) const noexcept {
  const forces::ForceRelaxation& relaxation = TipRelaxation(state);
  double force_n = law(ahead_mm);
  if (relaxation.num_terms == 0) return force_n;
  force_n *= relaxation.ElasticShare();
  for (int k = 0; k < relaxation.num_terms; ++k) {
    force_n += relaxation.share[k] * law(std::max(0.0, ahead_mm - state.rest_mm[k]));
  }
  return force_n;
}

/// Force of the membrane that the tip presses.
double SpringModel::PressedN(const SpringState& state, double ahead_mm) const noexcept {
  const forces::PuncturePolynomial& membrane = table_.tissue[state.membrane_of].membrane;
  return TipN(state, ahead_mm, [&](double in_mm) { return membrane.ForceN(in_mm); });
}

/// First contact: a node where the skin is between the last place outside and this one.
void SpringModel::Touch(SpringState& state, const Eigen::Vector3d& before_mm,
                        bool was_outside) const noexcept {
  Eigen::Vector3d skin_mm = state.device_in_ct_mm;
  if (was_outside) {
    skin_mm = BoundaryMm(before_mm, state.device_in_ct_mm,
                         [&](const Eigen::Vector3d& p) { return tissue_at_(p) == 0; });
  }
  const volume::Label below = tissue_at_(skin_mm + 1e-6 * (state.device_in_ct_mm - before_mm));
  const volume::Label tissue = below != 0 ? below : state.tissue_at_tip;
  state.num_nodes = 1;
  state.node[0] = {};
  state.node[0].rest_in_ct_mm = skin_mm;
  SetTissue(state.node[0], tissue);
  state.on_bone = table_.tissue[tissue].impenetrable;
  state.pressing = !state.on_bone && table_.HasMembrane(0, tissue);
  state.pierced = !state.pressing && !state.on_bone;
  state.membrane_of = tissue;
  state.bone_from_mm = state.ahead_mm = state.friction_n = 0.0;
  state.rest_mm.fill(0.0);
  state.pace = {};
  state.slid_mm = 0.0;
}

bool SpringModel::HasLeft(const SpringState& state) const noexcept {
  const PathNode& tip = state.node[state.num_nodes - 1];
  const Eigen::Vector3d off_mm = state.device_in_ct_mm - tip.rest_in_ct_mm;
  const double ahead_mm = off_mm.dot(state.axis_in_ct);
  const double aside_mm = (off_mm - ahead_mm * state.axis_in_ct).norm();
  if (state.num_nodes == 1 && ahead_mm < -(state.pierced ? kSpringSlackMm : kSpringTremorMm))
    return true;
  if (state.tissue_at_tip != 0) return false;
  return aside_mm > (state.pierced ? kSpringEscapeMm : kSpringTremorMm);
}

/// Eq. 6: the tissue sticks to the shaft until the spring holds as much as friction can.
void SpringModel::DragShaft(SpringState& state, double travel_mm, double dt_s) const noexcept {
  if (table_.HasTime()) return DragInTime(state, travel_mm, dt_s);
  for (int i = 1; i < state.num_nodes; ++i) {
    PathNode& node = state.node[i];
    node.offset_mm =
        FrictionOffsetMm(node.offset_mm, travel_mm, node.axial_n_per_mm, node.friction_n);
  }
}

/// The tip of the path moves towards the node behind it.
void SpringModel::DrawBack(SpringState& state, double back_mm) const noexcept {
  while (back_mm > 0.0 && state.num_nodes >= 2) {
    PathNode& tip = state.node[state.num_nodes - 1];
    const PathNode& behind = state.node[state.num_nodes - 2];
    const Eigen::Vector3d to_behind = behind.rest_in_ct_mm - tip.rest_in_ct_mm;
    const double length_mm = to_behind.norm();
    if (back_mm >= length_mm) {
      --state.num_nodes;
      back_mm -= length_mm;
      continue;
    }
    tip.rest_in_ct_mm += (back_mm / length_mm) * to_behind;
    if (hu_at_) SetByHu(tip);
    back_mm = 0.0;
    if (length_mm >= 0.5 * settings_.node_spacing_mm || state.num_nodes < 3) break;
    // The two segments become one, with the same force in it.
    const double tip_weight = Weight(state, state.num_nodes - 1);
    const double behind_weight = Weight(state, state.num_nodes - 2);
    PathNode merged = tip;
    SetTissue(merged, behind.tissue);
    merged.offset_mm = (tip_weight * tip.offset_mm + behind_weight * behind.offset_mm) /
                       (tip_weight + behind_weight);
    for (std::size_t k = 0; k < merged.relaxing_mm.size(); ++k) {
      merged.relaxing_mm[k] =
          (tip_weight * merged.relaxing_mm[k] + behind_weight * behind.relaxing_mm[k]) /
          (tip_weight + behind_weight);
    }
    --state.num_nodes;
    state.node[state.num_nodes - 1] = merged;
  }
}

/// Eq. 4 and what follows from it, for all the tissues that the tip gets to in this step.
NeedleEvent SpringModel::Advance(SpringState& state) const noexcept {
  NeedleEvent event = NeedleEvent::kNone;
  for (int i = 0; i < kSpringMostSubsteps; ++i) {
    PathNode& tip = state.node[state.num_nodes - 1];
    state.ahead_mm = (state.device_in_ct_mm - tip.rest_in_ct_mm).dot(state.tip_direction_in_ct);
    if (state.ahead_mm <= 0.0) {
      const bool unpierced = state.num_nodes == 1 && !state.pierced;
      if (!unpierced) state.pressing = state.on_bone = false;
      if (unpierced || state.num_nodes == 1) break;
      DrawBack(state, -state.ahead_mm);
      if (state.num_nodes > 1) state.ahead_mm = 0.0;
      break;
    }
    if (state.on_bone) break;
    if (state.pressing) {
      const double puncture_n = table_.tissue[state.membrane_of].membrane.puncture_n;
      if (PressedN(state, state.ahead_mm) < puncture_n) break;
      event = FirstOf(event, GiveWay(state));
      continue;
    }
    if (state.num_nodes == 1) {
      AppendTip(state);
      continue;
    }
    const double advance_mm =
        TipAdvanceMm(state.ahead_mm, tip.a1_n_per_mm, tip.a2_n_per_mm2, tip.cutting_n);
    if (advance_mm <= kSpringTinyMm) break;
    const double step_mm = std::min(advance_mm, 0.5 * settings_.node_spacing_mm);
    const Ahead ahead = LookAhead(state, step_mm);
    if (ahead.tissue != tip.tissue) {
      event = FirstOf(event, Meet(state, ahead.tissue, ahead.at_mm));
    } else {
      MoveTip(state, tip.rest_in_ct_mm + step_mm * state.tip_direction_in_ct);
    }
  }
  return event;
}

/// The first other tissue within `step_mm` of the tip that is more than noise: thin layers are not
/// stepped over. The tip's own if there is none.
SpringModel::Ahead SpringModel::LookAhead(const SpringState& state, double step_mm) const noexcept {
  const PathNode& tip = state.node[state.num_nodes - 1];
  const int looks = std::max(1, static_cast<int>(std::ceil(step_mm / kSpringLookMm)));
  for (int look = 1; look <= looks; ++look) {
    const double at_mm = look == looks ? step_mm : look * kSpringLookMm;
    const Eigen::Vector3d there_mm = tip.rest_in_ct_mm + at_mm * state.tip_direction_in_ct;
    const volume::Label next = tissue_at_(there_mm);
    const bool is_other = next != tip.tissue &&
                          next == tissue_at_(there_mm + table_.settings.interface_hysteresis_mm *
                                                            state.tip_direction_in_ct);
    if (is_other) return {next, at_mm};
  }
  return {tip.tissue, step_mm};
}

NeedleEvent SpringModel::GiveWay(SpringState& state) const noexcept {
  state.pressing = false;
  if (!state.pierced) {
    state.pierced = true;
    AppendTip(state);
  }
  SetTissue(state.node[state.num_nodes - 1], state.membrane_of);  // Whose series it has already.
  return NeedleEvent::kPuncture;
}

/// Moves the tip to the place where the tissue changes, and decides what happens there.
NeedleEvent SpringModel::Meet(SpringState& state, volume::Label next,
                              double step_mm) const noexcept {
  const PathNode before = state.node[state.num_nodes - 1];
  const Eigen::Vector3d to_mm = before.rest_in_ct_mm + step_mm * state.tip_direction_in_ct;
  MoveTip(state, BoundaryMm(before.rest_in_ct_mm, to_mm,
                            [&](const Eigen::Vector3d& p) { return tissue_at_(p) != next; }));
  PathNode& tip = state.node[state.num_nodes - 1];
  state.ahead_mm = (state.device_in_ct_mm - tip.rest_in_ct_mm).dot(state.tip_direction_in_ct);
  if (table_.tissue[next].impenetrable) {
    state.on_bone = true;
    // What cut the last tissue is pressed in already; the rest of the travel to here was not.
    state.bone_from_mm = std::min(state.ahead_mm, CuttingAheadMm(before));
    return NeedleEvent::kBoneContact;
  }
  const forces::ForceRelaxation& relaxation = TipRelaxation(state);
  if (table_.HasMembrane(before.tissue, next)) {
    state.pressing = true;
    state.membrane_of = next;
  } else {
    SetTissue(tip, next);
  }
  TakeTipOver(state, relaxation);
  return NeedleEvent::kInterface;
}

/// Puts nodes behind the tip where the last segment gets long.
void SpringModel::MoveTip(SpringState& state, const Eigen::Vector3d& to_mm) const noexcept {
  PathNode tip = state.node[state.num_nodes - 1];
  AdvanceRests(state, (to_mm - tip.rest_in_ct_mm).dot(state.tip_direction_in_ct));
  tip.rest_in_ct_mm = to_mm;
  while (true) {
    const PathNode& behind = state.node[state.num_nodes - 2];
    const Eigen::Vector3d segment = to_mm - behind.rest_in_ct_mm;
    const double length_mm = segment.norm();
    if (length_mm <= 1.5 * settings_.node_spacing_mm) break;
    if (state.num_nodes == SpringState::kMaxNodes) {
      ++state.num_path_full;
      break;
    }
    PathNode between;
    between.rest_in_ct_mm =
        behind.rest_in_ct_mm + (settings_.node_spacing_mm / length_mm) * segment;
    between.tissue = tip.tissue;
    between.offset_mm = tip.offset_mm;
    between.relaxing_mm = tip.relaxing_mm;
    between.axial_n_per_mm = tip.axial_n_per_mm;
    SetTissue(between, tissue_at_(between.rest_in_ct_mm));
    state.node[state.num_nodes - 1] = between;
    ++state.num_nodes;
  }
  if (hu_at_) SetByHu(tip);
  state.node[state.num_nodes - 1] = tip;
}

/// The node on the skin stays; a new tip begins there.
void SpringModel::AppendTip(SpringState& state) const noexcept {
  ACUS_ASSERT(state.num_nodes == 1);
  state.node[1] = state.node[0];
  state.node[1].offset_mm = 0.0;
  state.node[1].relaxing_mm.fill(0.0);
  state.num_nodes = 2;
}

void SpringModel::SetTissue(PathNode& node, volume::Label tissue) const noexcept {
  const PathNode& of = node_of_[tissue];
  TakeMeanOffset(node, tissue);
  node.tissue = tissue;
  node.lateral_n_per_mm = of.lateral_n_per_mm;
  if (hu_at_) return SetByHu(node);
  node.axial_n_per_mm = of.axial_n_per_mm;
  node.friction_n = of.friction_n;
  node.a1_n_per_mm = of.a1_n_per_mm;
  node.a2_n_per_mm2 = of.a2_n_per_mm2;
  node.cutting_n = of.cutting_n;
  HoldOffsets(node);
}

/// A stiffer place takes the spring's force over, in a softer one it keeps its length: neither
/// gives energy.
void SpringModel::SetByHu(PathNode& node) const noexcept {
  const forces::SpringParameters at = table_.hu_springs.At(hu_at_(node.rest_in_ct_mm));
  const double stiffness = at.shaft_n_per_mm2 * settings_.node_spacing_mm;
  if (stiffness > node.axial_n_per_mm) {
    node.offset_mm *= node.axial_n_per_mm / stiffness;
    for (double& offset_mm : node.relaxing_mm) offset_mm *= node.axial_n_per_mm / stiffness;
  }
  node.axial_n_per_mm = stiffness;
  node.friction_n = at.friction_n_per_mm * settings_.node_spacing_mm;
  node.a1_n_per_mm = at.a1_n_per_mm;
  node.a2_n_per_mm2 = at.a2_n_per_mm2;
  node.cutting_n = at.cutting_n;
  HoldOffsets(node);
}

PathNode SpringModel::NodeAt(const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
  PathNode node;
  node.rest_in_ct_mm = rest_in_ct_mm;
  SetTissue(node, tissue_at_(rest_in_ct_mm));
  return node;
}

double SpringModel::Weight(const SpringState& state, int i) const noexcept {
  return (state.node[i].rest_in_ct_mm - state.node[i - 1].rest_in_ct_mm).norm() /
         settings_.node_spacing_mm;
}

Eigen::Vector3d SpringModel::LateralForceN(const SpringState& state, int i,
                                           const Eigen::Vector3d& needle_in_ct_mm,
                                           const Eigen::Vector3d& tangent_in_ct) const noexcept {
  const Eigen::Vector3d off_mm = state.node[i].rest_in_ct_mm - needle_in_ct_mm;
  const Eigen::Vector3d across_mm = off_mm - off_mm.dot(tangent_in_ct) * tangent_in_ct;
  return state.node[i].lateral_n_per_mm * Weight(state, i) * across_mm;
}

/// Eq. 5 and 7, the membrane, bone, and the springs across the rigid needle.
void SpringModel::Forces(SpringState& state, double dt_s, double ahead_before_mm) const noexcept {
  forces::NeedleForce& out = state.force;
  const PathNode& tip = state.node[state.num_nodes - 1];
  const double ahead_mm = std::max(state.ahead_mm, 0.0);
  if (state.pierced) {
    out.cutting_n = TipN(state, ahead_mm, [&](double in_mm) { return CuttingN(tip, in_mm); });
  }
  if (state.pressing) {
    out.puncture_n = std::max(0.0, PressedN(state, ahead_mm) - out.cutting_n);
  }
  if (state.on_bone) {
    out.bone_penetration_mm = std::max(0.0, ahead_mm - state.bone_from_mm);
    out.bone_n =
        table_.settings.bone.ForceN(out.bone_penetration_mm, (ahead_mm - ahead_before_mm) / dt_s);
  }
  double friction_n = 0.0;
  double depth_mm = 0.0;
  double across_n_per_mm = 0.0;
  Eigen::Vector3d lateral_n = Eigen::Vector3d::Zero();
  for (int i = 1; i < state.num_nodes; ++i) {
    const PathNode& node = state.node[i];
    const double weight = Weight(state, i);
    friction_n += node.axial_n_per_mm * weight * HeldOffsetMm(node);
    depth_mm += weight * settings_.node_spacing_mm;
    across_n_per_mm += node.lateral_n_per_mm * weight;
    if (!state.bends) {
      lateral_n += LateralForceN(state, i, state.device_in_ct_mm, state.axis_in_ct);
    }
  }
  const double largest_n = settings_.friction_rate_n_per_s * dt_s;
  state.friction_n += std::clamp(friction_n - state.friction_n, -largest_n, largest_n);
  out.friction_n = state.friction_n;
  out.depth_mm = depth_mm + ahead_mm - out.bone_penetration_mm;
  // What all springs together pull with is no stiffer than a device can hold, and its energy then
  // does not depend on how many they are.
  const double stiffest = settings_.stiffest_across_n_per_mm;
  const double share = across_n_per_mm > stiffest ? stiffest / across_n_per_mm : 1.0;
  const double size_n = share * lateral_n.norm();
  const double limit_n = table_.settings.lateral_limit_n;
  state.lateral_share = size_n > limit_n ? share * limit_n / size_n : share;
  out.lateral_n = std::min(size_n, limit_n);
  out.force_in_ct_n = state.lateral_share * lateral_n - out.AxialN() * state.axis_in_ct;
}

void SpringModel::LoadOf(const SpringState& state, TissueLoad& out) const noexcept {
  static_assert(SpringState::kMaxNodes <= TissueLoad::kMaxPoints);
  out.num_points = state.num_nodes;
  out.needle = {};
  if (state.num_nodes == 0) return;
  for (int i = 0; i < state.num_nodes; ++i) {
    out.point[i].rest_in_ct_mm = state.node[i].rest_in_ct_mm;
    out.point[i].force_in_ct_n.setZero();
    if (i == 0) continue;
    const double axial_n =
        state.node[i].axial_n_per_mm * Weight(state, i) * state.node[i].offset_mm;
    out.point[i].force_in_ct_n = axial_n * state.axis_in_ct;
    if (state.bends) continue;  // It lies in its path: what its springs still do is not shown.
    out.point[i].force_in_ct_n -=
        state.lateral_share * LateralForceN(state, i, state.device_in_ct_mm, state.axis_in_ct);
  }
  const forces::NeedleForce& force = state.force;
  const double tip_n = force.cutting_n + force.puncture_n + force.bone_n;
  out.point[state.num_nodes - 1].force_in_ct_n += tip_n * state.axis_in_ct;
  out.needle.in_contact = true;
  out.needle.pierced = state.pierced;
  out.needle.entry_in_ct_mm = state.node[0].rest_in_ct_mm;
  out.needle.tip_in_ct_mm =
      state.bends
          ? state.node[state.num_nodes - 1].rest_in_ct_mm +
                (std::max(state.ahead_mm, 0.0) - force.bone_penetration_mm) *
                    state.tip_direction_in_ct
          : Eigen::Vector3d(state.device_in_ct_mm - force.bone_penetration_mm * state.axis_in_ct);
  out.needle.axis_in_ct = state.axis_in_ct;
  out.needle.pre_puncture_n = force.puncture_n;
  out.needle.cutting_n = force.cutting_n + force.bone_n;
  out.needle.friction_n = force.friction_n;
}

}  // namespace acus::tissue
