#include "acus/physics/needle/bendable_needle.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "acus/base/core/error.h"
#include "acus/physics/needle/rod_sweeps.h"

namespace acus::needle {

using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

bool IsUsable(const BendableNeedleInput& input) noexcept {
  const double norm2 = input.hand.squaredNorm();
  return IsNear(input.tip_mm) && norm2 > 1e-12 && norm2 < 1e12 &&
         std::abs(input.advance_mm) <= kFarthestMm && input.tissue.stiffness_n_per_mm2 >= 0.0 &&
         input.tissue.stiffness_n_per_mm2 <= kStiffest;
}

}  // namespace

BendableNeedle::BendableNeedle(const RodProperties& properties,
                               const BendableNeedleOptions& options)
    : rod_(properties, options.rod), options_(options) {
  const auto require = [](bool holds, const char* what, double value) {
    ACUS_REQUIRE(holds, "bendable needle: ", what, " is ", value, "; it must be above 0");
  };
  require(options.path_spacing_mm > 0.0, "path_spacing_mm", options.path_spacing_mm);
  require(options.hand.stiffness_n_per_mm > 0.0, "the hand's stiffness in N/mm",
          options.hand.stiffness_n_per_mm);
  require(options.hand.stiffness_n_mm_per_rad > 0.0, "the hand's stiffness in N mm/rad",
          options.hand.stiffness_n_mm_per_rad);
  require(options.coupling.tip_stiffness_n_per_mm > 0.0, "the tip's stiffness in N/mm",
          options.coupling.tip_stiffness_n_per_mm);
  require(options.kappa_n_per_mm > 0.0, "kappa", options.kappa_n_per_mm);
  ACUS_REQUIRE(std::isfinite(options.bevel.curvature_per_mm),
               "bendable needle: the bevel's curvature is not a number");
}

BendableNeedleState BendableNeedle::NewState() const {
  BendableNeedleState state;
  state.rod = rod_.NewState();
  state.path.spacing_mm = options_.path_spacing_mm;
  state.contacts.resize(rod_.num_elements() + 3);
  return state;
}

void BendableNeedle::MovePath(BendableNeedleState& state,
                              const BendableNeedleInput& input) const noexcept {
  const RodPoint& tip = state.rod.point.back();
  if (state.path.empty()) {
    if (!input.touches) return;
    state.heading = input.hand.normalized() * Vector3d::UnitZ();
    PathNode entry = input.tissue;
    entry.position_mm = input.tip_mm - std::max(0.0, input.advance_mm) * state.heading;
    state.path.Begin(entry);
    if (!(input.advance_mm > 0.0)) return;
  }
  if (input.advance_mm < 0.0) {
    state.path.Retract(-input.advance_mm);
    state.heading = state.path.empty() ? state.heading
                                       : state.path.Direction(state.path.LengthMm(), state.heading);
  } else if (input.advance_mm > 0.0 && options_.bevel.curvature_per_mm != 0.0) {
    const BevelTip::Heading next =
        options_.bevel.After(input.advance_mm, state.heading, tip.orientation * Vector3d::UnitX(),
                             tip.orientation * Vector3d::UnitY());
    state.path.Advance(next.chord, input.advance_mm, input.tissue);
    state.heading = next.end;
  } else if (input.advance_mm > 0.0) {
    state.heading = tip.tangent;
    state.path.Advance(state.heading, input.advance_mm, input.tissue);
  }
}

BendableNeedle::Entry BendableNeedle::EntryNow(const BendableNeedleState& state,
                                               const BendableNeedleInput& input) const noexcept {
  const Vector3d& rest_mm = state.path.entry().position_mm;
  const Vector3d direction = state.path.Direction(0.0, input.hand.normalized() * Vector3d::UnitZ());
  if (input.motion == nullptr) return {rest_mm, direction};
  const Vector3d now_mm = input.motion->NowMm(rest_mm);
  return {now_mm, (input.motion->NowMm(rest_mm + direction) - now_mm).normalized()};
}

RodInput BendableNeedle::InHand(const BendableNeedleState& state,
                                const BendableNeedleInput& input) const noexcept {
  RodInput rod;
  const double length_mm = rod_.properties().length_mm;
  if (state.path.empty()) {
    rod.base.orientation = input.hand;
    rod.base.position_mm = input.tip_mm - length_mm * (input.hand.normalized() * Vector3d::UnitZ());
    return rod;
  }
  rod.base = BaseFromHand(EntryNow(state, input).position_mm, length_mm - state.path.LengthMm(),
                          input.hand.normalized(), options_.hand);
  rod.contacts = {state.contacts.data(), static_cast<std::size_t>(state.num_contacts)};
  return rod;
}

BendableNeedleStep BendableNeedle::Step(BendableNeedleState& state,
                                        const BendableNeedleInput& input) const noexcept {
  BendableNeedleStep step;
  step.tip_direction = state.rod.point.back().tangent;
  if (!IsUsable(input)) {
    ++state.rod.num_rejected;
    step.rod = state.rod.last;
    step.rod.status = RodStatus::kRejected;
    return step;
  }
  if (!state.rod.started) rod_.Solve(state.rod, InHand(state, input));
  MovePath(state, input);
  state.num_contacts = CoupleToPath(rod_, state.path, options_.coupling, state.contacts);
  if (input.motion != nullptr) {
    MoveContacts(*input.motion, std::span(state.contacts).first(state.num_contacts));
  }
  if (options_.hand_has_potential && !state.path.empty()) {
    const Vector3d axis = input.hand.normalized() * Vector3d::UnitZ();
    RodContact& hub = state.contacts[state.num_contacts++];
    hub.arc_mm = 0.0;
    hub.anchor_mm = input.tip_mm - rod_.properties().length_mm * axis;
    hub.free_axis = EntryNow(state, input).direction;
    hub.stiffness_n_per_mm = options_.kappa_n_per_mm;
  }
  step.rod = rod_.Solve(state.rod, InHand(state, input));
  step.tip_direction = options_.bevel.curvature_per_mm != 0.0 && !state.path.empty()
                           ? state.heading
                           : state.rod.point.back().tangent;
  if (!state.path.empty()) HandOf(state, input, step);
  return step;
}

void BendableNeedle::HandOf(const BendableNeedleState& state, const BendableNeedleInput& input,
                            BendableNeedleStep& step) const noexcept {
  const double length_mm = rod_.properties().length_mm;
  const Quaterniond hand = input.hand.normalized();
  const Vector3d axis = hand * Vector3d::UnitZ();
  const double outside_mm = length_mm - state.path.LengthMm();
  step.hand_force_n = HandForceN(options_.kappa_n_per_mm, state.rod.point[0].position_mm,
                                 input.tip_mm - length_mm * axis, EntryNow(state, input).direction);
  if (!options_.hand_has_potential) {
    step.hand_torque_n_mm = HandTorqueNMm(options_.hand.stiffness_n_mm_per_rad, hand,
                                          rod_.Tangent(state.rod, outside_mm));
    return;
  }
  // The hand's turn about tip_mm turns the orientation that draws the hub, moves the place that
  // draws it, and the end of the spring of eq. 8.
  step.hand_torque_n_mm = step.rod.base_torque_n_mm -
                          outside_mm * axis.cross(step.rod.base_force_n) -
                          length_mm * axis.cross(step.hand_force_n);
}

}  // namespace acus::needle
