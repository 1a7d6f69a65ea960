// PlaneModel2010: which nodes the needle touches, what it may do to them, and how its tip cuts.
//
// The shaft and the tip act on the nodes by linear interpolation along the path: node q carries
// phi_q(s) of what acts at depth s, phi_q the hat function of its depth. So all bounds are
// continuous in the position of the tip, and a node comes and goes without force.
#include <algorithm>
#include <cmath>

#include "acus/physics/tissue/plane_model_2010.h"

namespace acus::tissue {
namespace {

using forces::NeedleEvent;

constexpr int kMostBalances = 8;         // Of forces and the tip's advance, in one substep.
constexpr double kBalancedShare = 0.02;  // Of the spacing: advance that calls for another.
constexpr double kLabelStepMm = 0.1;     // Along the path, between looks at the tissue.
constexpr double kTinyMm = 1e-6;
constexpr double kTinyN = 1e-9;
constexpr double kForgottenN = 1e-6;
constexpr int kPlaneBisections = 30;

/// Integral from `from` to `to` of the ramp that is 0 at `low` and 1 at `high`, within [low, high].
double RampIntegral(double low, double high, double from, double to) {
  from = std::clamp(from, low, high);
  to = std::clamp(to, low, high);
  if (to <= from) return 0.0;
  return ((to - low) * (to - low) - (from - low) * (from - low)) / (2.0 * (high - low));
}

double Overlap(double low, double high, double from, double to) {
  return std::max(0.0, std::min(high, to) - std::max(low, from));
}

}  // namespace

double PlaneModel2010::Hat(const PlaneState& state, int q, double at_mm) const noexcept {
  const double here_mm = state.node[q].at_mm;
  if (at_mm <= here_mm) {
    if (q == 0) return 1.0;
    const double before_mm = state.node[q - 1].at_mm;
    return std::clamp((at_mm - before_mm) / (here_mm - before_mm), 0.0, 1.0);
  }
  if (q == state.num_nodes - 1) return 1.0;
  const double after_mm = state.node[q + 1].at_mm;
  return std::clamp((after_mm - at_mm) / (after_mm - here_mm), 0.0, 1.0);
}

/// Integral of the hat function from the skin to `end_mm`: the length of shaft that the node stands
/// for.
double PlaneModel2010::HatIntegral(const PlaneState& state, int q, double end_mm) const noexcept {
  const double here_mm = state.node[q].at_mm;
  double sum = 0.0;
  if (q == 0) {
    sum += Overlap(0.0, end_mm, -1e9, here_mm);
  } else {
    sum += RampIntegral(state.node[q - 1].at_mm, here_mm, 0.0, end_mm);
  }
  if (q == state.num_nodes - 1) {
    sum += Overlap(0.0, end_mm, here_mm, 1e9);
  } else {
    const double after_mm = state.node[q + 1].at_mm;
    sum += Overlap(here_mm, after_mm, 0.0, end_mm) - RampIntegral(here_mm, after_mm, 0.0, end_mm);
  }
  return sum;
}

double PlaneModel2010::AlongDisplacementMm(const PlaneState& state, double at_mm) const noexcept {
  double sum = 0.0;
  for (int q = 0; q < state.num_nodes; ++q) {
    const double hat = Hat(state, q, at_mm);
    if (hat > 0.0) sum += hat * state.contact.DisplacementMm(2 * q);
  }
  return sum;
}

double PlaneModel2010::TipLimitN(const PlaneState& state) const noexcept {
  const double cutting_n = table_.tissue[state.cut_tissue].cutting_n;
  if (!state.pressing) return cutting_n;
  return std::max(cutting_n, table_.tissue[state.membrane_of].membrane.puncture_n);
}

/// What each node is asked to do, and within which forces.
void PlaneModel2010::SetDemands(PlaneState& state, double lead_mm) const noexcept {
  if (!state.pierced()) {  // The tip presses on the skin; it can slide across and let go.
    const bool presses = state.pressing;
    const double limit_n = presses ? table_.tissue[state.membrane_of].membrane.puncture_n : 0.0;
    state.contact.SetDemand(0, state.needle_mm, 0.0, limit_n);
    state.contact.SetDemand(1, 0.0, 0.0, 0.0);
    return;
  }
  const double tip_n = state.engaged ? TipLimitN(state) : 0.0;
  const double buried_mm = std::max(0.0, state.tip_rest_mm + lead_mm);
  for (int q = 0; q < state.num_nodes; ++q) {
    const PlaneNode& node = state.node[q];
    const double length_mm = HatIntegral(state, q, buried_mm);
    const double shaft_n = FrictionNPerMm(state, node) * length_mm;
    const double at_tip_n = tip_n * Hat(state, q, state.channel_mm + lead_mm);
    state.contact.SetDemand(2 * q, state.needle_mm - node.reference_mm.x(), -shaft_n,
                            shaft_n + at_tip_n);
    const double across_n = settings_.lateral_limit_n_per_mm * length_mm;
    state.contact.SetDemand(2 * q + 1, AcrossMm(state, node.at_mm) - node.reference_mm.y(),
                            -across_n, across_n);
  }
}

/// Where a node has slipped, it will stick at the place of the shaft that it is at now.
void PlaneModel2010::KeepSlips(PlaneState& state) const noexcept {
  if (!state.pierced()) return;
  for (int q = 0; q < state.num_nodes; ++q) {
    PlaneNode& node = state.node[q];
    if (state.contact.Status(2 * q) != SlotStatus::kStick) {
      const double before_mm = node.reference_mm.x();
      node.reference_mm.x() = state.needle_mm - state.contact.DisplacementMm(2 * q);
      state.slid_mm += (node.reference_mm.x() - before_mm) / state.num_nodes;
    }
    if (state.contact.Status(2 * q + 1) != SlotStatus::kStick) {
      node.reference_mm.y() = AcrossMm(state, node.at_mm) - state.contact.DisplacementMm(2 * q + 1);
    }
  }
}

/// The tip is withdrawn beyond the last node but one, and the last has no force any more.
bool PlaneModel2010::CanDropLast(const PlaneState& state) const noexcept {
  const int last = state.num_nodes - 1;
  if (last < 1 || state.engaged || state.tip_rest_mm >= state.node[last - 1].at_mm) return false;
  for (const int slot : {2 * last, 2 * last + 1}) {
    if (state.contact.HighN(slot) > 0.0) return false;
    // Tissue that has not come back yet would jump.
    if (std::abs(state.contact.ElasticN(slot)) > kForgottenN) return false;
  }
  return true;
}

/// Forces in balance with where the needle is, and the tip where they let it be.
NeedleEvent PlaneModel2010::Balance(PlaneState& state, double travel_mm) const noexcept {
  NeedleEvent event = NeedleEvent::kNone;
  // A tip that cuts is expected to continue: the load moves with the needle, not after it.
  double lead_mm =
      state.cutting && !state.pressing && !state.on_bone ? std::max(0.0, travel_mm) : 0;
  const double channel_before_mm = state.channel_mm;
  for (int round = 0; round < kMostBalances; ++round) {
    while (state.pierced() &&
           state.tip_rest_mm + lead_mm >= state.node[state.num_nodes - 1].at_mm) {
      if (!AppendNode(state, std::max(0.0, travel_mm))) break;
    }
    SetDemands(state, lead_mm);
    lead_mm = 0.0;
    state.contact.Solve(settings_.force_error_n);
    KeepSlips(state);
    const double before_mm = state.tip_rest_mm;
    const NeedleEvent now = state.pierced() ? FollowTip(state) : Pierce(state);
    event = FirstOf(event, now);
    while (CanDropLast(state)) {
      state.contact.DropLast();
      --state.num_nodes;
      state.next_layer -= LayerStep(state);
    }
    const bool settled =
        std::abs(state.tip_rest_mm - before_mm) < kBalancedShare * settings_.spacing_mm;
    if (settled && now == NeedleEvent::kNone) break;
  }
  state.cutting = state.engaged && state.channel_mm > channel_before_mm;
  return event;
}

/// The skin yields when it is pressed with all that it can bear.
NeedleEvent PlaneModel2010::Pierce(PlaneState& state) const noexcept {
  if (!state.pressing || state.contact.Status(0) != SlotStatus::kAtHigh) {
    state.tip_rest_mm = 0.0;
    return NeedleEvent::kNone;
  }
  const double pressed_in_mm = state.contact.DisplacementMm(0);
  const Eigen::Vector2d across(-state.along.y(), state.along.x());
  const Eigen::Vector2d tip_mm =
      state.entry_mm + state.device_mm * state.along + state.aside_mm * across;
  // The path is locked to the needle's direction now (Augmented-2010, II.D).
  const Eigen::Vector2d axis =
      (state.along + std::clamp(state.slope, -1.0, 1.0) * across).normalized();
  const PlaneContact::Past past_n = state.contact.PastOf(0);
  StartPath(state, axis, tip_mm - state.device_mm * axis);
  state.aside_mm = state.slope = 0.0;
  state.pressing = false;
  if (!AppendNode(state, 0.0)) {
    Leave(state);
    return NeedleEvent::kNone;
  }
  state.contact.SetPast(0, past_n);
  state.phase = NeedlePhase::kInside;
  state.engaged = true;
  state.cut_tissue = state.membrane_of;
  state.node[0].reference_mm.x() = state.needle_mm - pressed_in_mm;
  state.tip_rest_mm = state.channel_mm = 0.0;
  return NeedleEvent::kPuncture;
}

/// The needle's tip is fixed to the needle; what tissue it is in depends on how far that has moved.
NeedleEvent PlaneModel2010::FollowTip(PlaneState& state) const noexcept {
  double rest_mm = state.tip_rest_mm;
  for (int i = 0; i < 3; ++i) {
    rest_mm = state.needle_mm - AlongDisplacementMm(state, std::min(rest_mm, state.channel_mm));
  }
  if (rest_mm < state.channel_mm) {
    state.tip_rest_mm = rest_mm;
    if (rest_mm > state.channel_mm - kTinyMm) return NeedleEvent::kNone;
    bool tip_pushes = false;
    for (int q = 0; q < state.num_nodes; ++q) {
      if (state.contact.ForceN(2 * q) > -state.contact.LowN(2 * q) + kTinyN) tip_pushes = true;
    }
    if (!tip_pushes) {
      state.engaged = false;
      if (rest_mm < state.channel_mm - table_.settings.interface_hysteresis_mm) {
        state.pressing = false;  // Withdrawn from an inner membrane.
      }
    }
    return NeedleEvent::kNone;
  }
  if (!state.engaged) {  // Back at the end of the channel; from here on it has to cut.
    state.engaged = true;
    state.tip_rest_mm = state.channel_mm;
    return NeedleEvent::kNone;
  }
  state.tip_rest_mm = state.channel_mm;
  if (state.on_bone) return NeedleEvent::kNone;
  if (state.pressing) {
    for (int q = 0; q < state.num_nodes; ++q) {
      const bool is_at_tip = Hat(state, q, state.channel_mm) > 0.0;
      if (is_at_tip && state.contact.Status(2 * q) != SlotStatus::kAtHigh) {
        return NeedleEvent::kNone;
      }
    }
    state.pressing = false;
    state.cut_tissue = state.membrane_of;
    return NeedleEvent::kPuncture;
  }
  const NeedleEvent event = AdvanceChannel(state, rest_mm);
  state.tip_rest_mm = state.channel_mm;
  return event;
}

/// Cuts to `to_mm`, or to where a membrane or bone stops the tip.
NeedleEvent PlaneModel2010::AdvanceChannel(PlaneState& state, double to_mm) const noexcept {
  NeedleEvent event = NeedleEvent::kNone;
  while (state.channel_mm < to_mm) {
    const double next_mm = std::min(to_mm, state.channel_mm + kLabelStepMm);
    const volume::Label next = LabelOnPath(state, next_mm);
    const bool is_other =
        next != state.cut_tissue &&
        next == LabelOnPath(state, next_mm + table_.settings.interface_hysteresis_mm);
    if (!is_other) {
      state.channel_mm = next_mm;
      continue;
    }
    double same_mm = state.channel_mm;
    double other_mm = next_mm;
    for (int i = 0; i < kPlaneBisections; ++i) {
      const double middle_mm = 0.5 * (same_mm + other_mm);
      (LabelOnPath(state, middle_mm) == next ? other_mm : same_mm) = middle_mm;
    }
    state.channel_mm = other_mm;
    if (table_.tissue[next].impenetrable) {
      state.on_bone = true;
      state.needle_mm -= to_mm - other_mm;
      state.bone_at_mm = state.needle_mm;
      return NeedleEvent::kBoneContact;
    }
    if (table_.HasMembrane(state.cut_tissue, next)) {
      state.pressing = true;
      state.membrane_of = next;
      // What remains of this step does not go through the membrane, it presses it in.
      for (int q = 0; q < state.num_nodes; ++q) {
        if (Hat(state, q, other_mm) > 0.0) state.node[q].reference_mm.x() -= to_mm - other_mm;
      }
      return FirstOf(event, NeedleEvent::kInterface);
    }
    state.cut_tissue = next;
    event = NeedleEvent::kInterface;
  }
  return event;
}

}  // namespace acus::tissue
