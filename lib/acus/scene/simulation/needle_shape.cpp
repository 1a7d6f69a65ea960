#include "acus/scene/simulation/needle_shape.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/physics/forces/models/needle_force.h"
#include "acus/physics/tissue/shaft_springs.h"

namespace acus::simulation {
namespace {

using Eigen::Vector3d;
using forces::NeedleForce;
using scenario::NeedleModelKind;

constexpr double kStillMm = 1e-6;       // A smaller motion is no advance: at rest no bit changes.
constexpr double kLetGoMm = 20.0;       // As far off the path as models of tissue allow.
constexpr double kGiftNMmPerS = 0.005;  // 0.3 mJ a minute, so that no force stays zero for good.

needle::BendableNeedleOptions OptionsOf(const scenario::NeedleEffect& effect,
                                        const needle::NeedleProperties& needle) {
  needle::BendableNeedleOptions options;
  options.rod.num_nodes = effect.nodes;
  options.path_spacing_mm = effect.path_spacing_mm;
  options.coupling.tip_stiffness_n_per_mm = effect.tip_stiffness_n_per_mm;
  options.hand = {effect.hand_n_per_mm, effect.hand_n_mm_per_rad};
  options.kappa_n_per_mm = effect.kappa_n_per_mm;
  options.hand_has_potential = effect.hand_has_potential;
  if (effect.bevel) options.bevel = needle.bevel;
  return options;
}

/// The orientation whose +z is exactly the needle's axis, and +x as nearly as that allows.
Eigen::Quaterniond OrientationOf(const Eigen::Matrix3d& ct_from_needle) noexcept {
  Eigen::Matrix3d axes;
  axes.col(2) = ct_from_needle.col(2).normalized();
  Vector3d x = ct_from_needle.col(0) - ct_from_needle.col(0).dot(axes.col(2)) * axes.col(2);
  const double norm = x.norm();
  axes.col(0) = norm > 1e-6 && norm < 1e6 ? Vector3d(x / norm) : axes.col(2).unitOrthogonal();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return Eigen::Quaterniond(axes);
}

}  // namespace

NeedleShapeModel::NeedleShapeModel(const scenario::NeedleEffect& effect,
                                   const needle::NeedleProperties& needle,
                                   const forces::ForceTable& table,
                                   const mechanics::ElasticityTable* elasticity,
                                   const std::bitset<256>& tissues, bool force_has_beam)
    : model_(effect.model),
      axis_lock_(effect.axis_lock),
      keeps_force_(force_has_beam && effect.model == NeedleModelKind::kLateralBeam),
      needle_(needle),
      settings_(table.settings) {
  if (model_ != NeedleModelKind::kBendable) return;
  ACUS_ASSERT(elasticity != nullptr);
  const double shaft_mm = 0.5 * needle.beam.outer_diameter_mm;
  ACUS_REQUIRE(effect.influence_radius_mm > 2.0 * shaft_mm,
               "effects/needle/influence_radius_mm is ", effect.influence_radius_mm,
               "; allowed: more than the needle's diameter, ", 2.0 * shaft_mm, " mm");
  bendable_.emplace(needle::RodOf(needle), OptionsOf(effect, needle));
  const double across = tissue::ShaftInCylinder(shaft_mm, effect.influence_radius_mm).across;
  for (int i = 1; i < 256; ++i) {
    const auto label = static_cast<volume::Label>(i);
    if (!tissues.test(label) || table.tissue[label].impenetrable) continue;
    stiffness_n_per_mm2_[label] = across * elasticity->At(label).ShearModulusMpa();
  }
}

NeedleShapeState NeedleShapeModel::NewState() const {
  NeedleShapeState state;
  if (bendable_) state.needle = bendable_->NewState();
  return state;
}

void NeedleShapeModel::Step(NeedleShapeState& state, const NeedleShapeInput& input,
                            NeedleForce& force) const noexcept {
  const Vector3d tip_in_ct_mm = input.ct_from_needle.translation();
  NeedleForce across;
  switch (state.gate.Judge(input.time_s, input.valid, tip_in_ct_mm,
                           input.ct_from_needle.linear().col(2))) {
    case forces::SampleGate::Verdict::kZero:
      break;
    case forces::SampleGate::Verdict::kHold:
      across = state.gate.Held(settings_);
      break;
    case forces::SampleGate::Verdict::kStep:
      Follow(state, input, force.depth_mm);
      if (model_ == NeedleModelKind::kLateralBeam && !keeps_force_)
        across = Beam(state, tip_in_ct_mm);
      if (bendable_) across = Bend(state, input, force);
      state.gate.Accept(input.time_s, across);
      break;
  }
  if (keeps_force_) return;
  force.lateral_n = across.lateral_n;
  force.torque_in_ct_n_mm = across.torque_in_ct_n_mm;
  force.force_in_ct_n = across.force_in_ct_n - force.AxialN() * state.line.direction_in_ct;
  forces::LimitTo(force, settings_.largest_force_n);
}

/// Keeps the line of the path: the force model's, or the one at the puncture.
void NeedleShapeModel::Follow(NeedleShapeState& state, const NeedleShapeInput& input,
                              double depth_mm) const noexcept {
  state.depth_mm = std::clamp(depth_mm, 0.0, needle_.length_mm);
  state.shape = {.tip_in_ct_mm = input.ct_from_needle.translation()};
  if (input.path != nullptr) {
    state.line = *input.path;
    return;
  }
  const bool keeps_line = model_ != NeedleModelKind::kRigid || axis_lock_;
  const Vector3d axis = input.ct_from_needle.linear().col(2).normalized();
  const bool turns = !keeps_line || bendable_.has_value();
  if (!input.pierced || !state.line.pierced || turns) {
    state.line.direction_in_ct = axis;
    state.line.entry_in_ct_mm = input.ct_from_needle.translation() - state.depth_mm * axis;
  }
  state.line.pierced = input.pierced;
}

Vector3d NeedleShapeModel::LockedTip(const NeedleShapeState& state,
                                     const Vector3d& tip_in_ct_mm) const noexcept {
  if (!axis_lock_ || !state.line.pierced) return tip_in_ct_mm;
  const PathLine& line = state.line;
  const double along_mm = (tip_in_ct_mm - line.entry_in_ct_mm).dot(line.direction_in_ct);
  const Vector3d on_path_mm = line.entry_in_ct_mm + along_mm * line.direction_in_ct;
  return (tip_in_ct_mm - on_path_mm).norm() > kLetGoMm ? tip_in_ct_mm : on_path_mm;
}

/// Augmented-2010, section II.D.
NeedleForce NeedleShapeModel::Beam(const NeedleShapeState& state,
                                   const Vector3d& tip_in_ct_mm) const noexcept {
  NeedleForce across;
  if (!state.line.pierced) return across;
  Vector3d off_mm = tip_in_ct_mm - state.line.entry_in_ct_mm;
  off_mm -= off_mm.dot(state.line.direction_in_ct) * state.line.direction_in_ct;
  const double size_mm = off_mm.norm();
  const double stiffness = forces::LateralStiffnessNPerMm(needle_, settings_, state.depth_mm);
  across.lateral_n = std::min(stiffness * size_mm, settings_.lateral_limit_n);
  if (size_mm > 0.0) across.force_in_ct_n = -(across.lateral_n / size_mm) * off_mm;
  return across;
}

/// Fortmeier-2016: the tip cuts in its own direction, the rod follows, eq. 8 gives the force.
NeedleForce NeedleShapeModel::Bend(NeedleShapeState& state, const NeedleShapeInput& input,
                                   const NeedleForce& along) const noexcept {
  NeedleForce across;
  needle::CurvedPath& path = state.needle.path;
  const bool in_air = !state.line.pierced;
  if (in_air && path.empty()) return across;
  needle::BendableNeedleInput hand;
  hand.tip_mm = input.ct_from_needle.translation();
  hand.hand = OrientationOf(input.ct_from_needle.linear());
  hand.touches = !in_air;
  hand.advance_mm = in_air ? -2.0 * needle_.length_mm : state.depth_mm - path.LengthMm();
  if (std::abs(hand.advance_mm) < kStillMm) hand.advance_mm = 0.0;
  hand.tissue.tissue = input.tissue_at_tip;
  hand.tissue.stiffness_n_per_mm2 = stiffness_n_per_mm2_[input.tissue_at_tip];
  hand.motion = input.motion;
  const bool begins = path.empty();
  const needle::BendableNeedleStep step = bendable_->Step(state.needle, hand);
  if (step.rod.status == needle::RodStatus::kRejected) return across;
  state.tip_direction_in_ct.setZero();
  state.tip_offset_mm.setZero();
  if (path.empty()) {
    state.needle.rod.started = false;  // The next insertion begins with a straight needle.
    state.hand.paid_n_mm = 0.0;
    state.hand.share = 1.0;
    return across;
  }
  const needle::RodState& rod = state.needle.rod;
  const Vector3d& hub_mm = rod.point.front().position_mm;
  const Vector3d& hub_axis = rod.point.front().tangent;
  const Vector3d tip_mm = rod.point.back().position_mm;
  const Vector3d from_hub_mm = tip_mm - hub_mm;
  state.shape = {true, tip_mm, (from_hub_mm - from_hub_mm.dot(hub_axis) * hub_axis).norm()};
  const Vector3d axis = hand.hand * Vector3d::UnitZ();
  const Vector3d offset_mm = tip_mm - hand.tip_mm;
  state.tip_offset_mm = offset_mm - offset_mm.dot(axis) * axis;
  state.tip_direction_in_ct = step.tip_direction;

  across.force_in_ct_n = step.hand_force_n;
  across.torque_in_ct_n_mm = step.hand_torque_n_mm;
  across.lateral_n = step.hand_force_n.norm();
  forces::LimitTo(across, settings_.lateral_limit_n);
  const double dt_s = state.gate.started ? input.time_s - state.gate.valid_time_s : 0.0;
  const double spent_n_mm = std::max(0.0, (along.cutting_n + along.friction_n) * hand.advance_mm) +
                            kGiftNMmPerS * std::min(dt_s, 0.1);
  if (begins) state.hand.Follow(hand.tip_mm, hand.hand);
  state.hand.Return(hand.tip_mm, hand.hand, {step.rod.energy_n_mm, spent_n_mm}, state.gate.held,
                    across);
  return across;
}

bool NeedleShapeModel::ShapeOf(const NeedleShapeState& state, math::Polyline& out) const noexcept {
  if (bendable_) {
    if (state.needle.path.empty()) return false;
    out.Clear();
    const auto& points = state.needle.rod.point;
    for (auto point = points.rbegin(); point != points.rend(); ++point) out.Add(point->position_mm);
    return true;
  }
  if (!axis_lock_ || !state.line.pierced) return false;
  const PathLine& line = state.line;
  out.Clear();
  out.Add(line.entry_in_ct_mm + state.depth_mm * line.direction_in_ct);
  out.Add(line.entry_in_ct_mm + (state.depth_mm - needle_.length_mm) * line.direction_in_ct);
  return true;
}

}  // namespace acus::simulation
