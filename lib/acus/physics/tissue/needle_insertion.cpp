// Points along the needle: where they are set, what is asked of them, and how the tip cuts.
#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/physics/tissue/local_compliance.h"
#include "acus/physics/tissue/needle_contact.h"
#include "acus/physics/tissue/needle_contact_limits.h"

namespace acus::tissue {
namespace {

constexpr int kMostNewPoints = 3;   // Per step: the rest follows in the next ones.
constexpr double kMarchMm = 0.5;    // So closely the tip looks for other tissues on its way.
constexpr int kHalvings = 12;       // Finds an interface to 0.1 um of that.
constexpr double kReplaceMm = 0.5;  // Of cutting, after which the tip's compliance is found again.
constexpr double kChannelMm =
    1.0;  // Further aside, the tip leaves its old cut and makes a new one.
constexpr double kNothingMmPerN = 1e6;  // Around a place without tissue.

}  // namespace

double FemNeedleModel::TipLimitN(const FemNeedleState& state) const noexcept {
  if (state.end_is_bone) return table_.settings.bone.largest_n;
  const double cutting_n = table_.tissue[state.end_tissue].cutting_n;
  if (state.membrane_n <= 0.0) return cutting_n;
  // The tissue before an inner membrane can be harder to cut than the membrane.
  return state.phase == NeedlePhase::kOnSkin ? state.membrane_n
                                             : std::max(state.membrane_n, cutting_n);
}

/// Where the needle's line is, across the frame, at this depth.
Eigen::Vector2d FemNeedleModel::LineMm(const FemNeedleState& state,
                                       double axial_mm) const noexcept {
  const Eigen::Vector3d tip = state.frame.transpose() * (state.tip_in_ct_mm - state.entry_mm);
  const Eigen::Vector3d axis = state.frame.transpose() * state.axis_in_ct;
  const Eigen::Vector2d slope = axis.head<2>() / std::max(axis.z(), kLeastCosine);
  return tip.head<2>() + (axial_mm - tip.z()) * slope;
}

/// Length of shaft that a point stands for: half way to its neighbours, the last one up to the tip.
/// Never negative: seen along a needle that was turned, points of a crooked channel can stand in
/// another order than they were set, and friction would drive the needle.
double FemNeedleModel::FrictionLengthMm(const FemNeedleState& state, int point) const noexcept {
  const NeedlePoint* const p = state.point.data() + point;
  const auto half_mm = [](const NeedlePoint& a, const NeedlePoint& b) {
    return std::max(0.0, 0.5 * (b.axial_mm - a.axial_mm));
  };
  const double before_mm = point > 0 ? half_mm(p[-1], *p) : 0.0;
  if (point + 1 < state.contact.num_points()) return before_mm + half_mm(*p, p[1]);
  const double most_mm = point + 1 < max_points_ ? spacing_mm_ : std::numeric_limits<double>::max();
  return before_mm + std::clamp(state.depth_mm - p->axial_mm - p->moved_mm, 0.0, most_mm);
}

/// What lies between the tip and the tissue that it presses; null: no shell.
const mechanics::Membrane* FemNeedleModel::MembraneBefore(
    const FemNeedleState& state) const noexcept {
  const volume::Label before =
      state.phase == NeedlePhase::kOnSkin ? volume::Label{0} : state.end_tissue;
  if (state.membrane_n <= 0.0) return nullptr;
  for (const mechanics::Membrane& membrane : membranes_) {
    if (membrane.tissue == state.beyond && membrane.against.test(before)) return &membrane;
  }
  return nullptr;
}

void FemNeedleModel::PlaceTip(FemNeedleState& state,
                              const Eigen::Vector3d& direction) const noexcept {
  const Spot spot = mesh_.Find(state.end_mm);
  const mechanics::ElasticTissue& tissue = elastic_[spot.tissue];
  const bool on_skin = state.phase == NeedlePhase::kOnSkin;
  const mechanics::Membrane* const membrane = MembraneBefore(state);
  ContactPlace place = spot.place;
  double radius_mm = 1.0;
  double local = kNothingMmPerN;
  if (state.end_is_bone) {
    local = 1.0 / table_.settings.bone.stiffness_n_per_mm;
  } else if (spot.inside && on_skin && membrane != nullptr && skin_shell_[membrane->tissue]) {
    radius_mm = KernelRadiusMm(spot.element_mm, 0.0);
    if (state.ground_mpa > 0.0) {
      radius_mm =
          DimpleRadiusMm(membrane->youngs_modulus_mpa * membrane->thickness_mm, state.ground_mpa,
                         state.kernel_moved_mm - state.dimple_from_mm, radius_mm);
    }
    place = kernel_.Disc(state.end_mm, radius_mm).place;
    local = skin_shell_[membrane->tissue]->MissingMmPerN(radius_mm);
    if (state.ground_mpa <= 0.0) {
      const double moved_mm_per_n = direction.dot(system_.Between(place, place) * direction);
      state.ground_mpa = moved_mm_per_n > 0.0 ? 1.0 / (moved_mm_per_n * radius_mm) : kRigidMpa;
    }
  } else if (spot.inside) {
    const double lump_mm = LumpRadiusMm(tissue, TipLimitN(state), on_skin, radius_mm_);
    radius_mm = KernelRadiusMm(spot.element_mm, lump_mm);
    const KernelPlace ball = kernel_.Ball(state.end_mm, radius_mm);
    place = ball.place;
    local = (on_skin ? PunchMobilityMm2PerN(tissue) : SphereMobilityMm2PerN(tissue)) *
                NearFieldPerMm(radius_mm, lump_mm) +
            SphereMobilityMm2PerN(tissue) * ball.self_per_mm;
  }
  const double force_n = std::max(0.0, state.contact.SlotForceN(0));  // Of the last step.
  state.dimple = {};
  if (membrane != nullptr && !state.end_is_bone) {
    state.dimple = {membrane->youngs_modulus_mpa * membrane->thickness_mm, radius_mm};
    if (on_skin) local = state.dimple.NearFieldMmPerN(local, force_n);
  }
  state.near_mm_per_n = local;
  state.stretch_n_per_mm = state.dimple.SlopeNPerMm(state.kernel_moved_mm - state.dimple_from_mm);
  system_.SetSlot(state.contact, 0, place, direction,
                  local / (1.0 + local * state.stretch_n_per_mm));
  state.placed_mm = state.end_mm;
}

/// A tip that moves by `displacement_mm` moves its kernel by w and the near field by the rest:
///   w + near (F + S(w)) = displacement, F of the slot, S of the dimple's stretching.
/// With S linear around the last step's w that is again a slot with a local compliance.
void FemNeedleModel::DemandTip(FemNeedleState& state, double displacement_mm) const noexcept {
  const double stretched_n = state.dimple.ForceN(state.kernel_moved_mm - state.dimple_from_mm);
  const double at_rest_n = stretched_n - state.stretch_n_per_mm * state.kernel_moved_mm;
  const double scale = 1.0 + state.near_mm_per_n * state.stretch_n_per_mm;
  state.contact.SetSlotExtra(0, stretched_n);
  state.contact.SetSlotDemand(0, (displacement_mm - state.near_mm_per_n * at_rest_n) / scale, 0.0,
                              TipLimitN(state));
}

void FemNeedleModel::FollowDimple(FemNeedleState& state) const noexcept {
  state.kernel_moved_mm = state.contact.DemandMm(0) + state.contact.SlotExcessMm(0) -
                          state.contact.slot_local_mm_per_n(0) * state.contact.ElasticSlotN(0);
  state.contact.SetSlotExtra(0, state.dimple.ForceN(state.kernel_moved_mm - state.dimple_from_mm));
}

/// The same where a harder limit begins: continues with the force as it is.
void FemNeedleModel::PlaceTipKeepingForce(FemNeedleState& state) const noexcept {
  const Eigen::Vector3d axial = state.frame.col(2);
  const double force_n = state.contact.ElasticSlotN(0);
  const auto moved_mm = [&] {
    const ContactPlace& place = state.contact.slot_place(0);
    return axial.dot(system_.DisplacementMm(state.contact, place) + StrainMovedMm(state, place)) +
           state.contact.slot_local_mm_per_n(0) * force_n;
  };
  const double before_mm = moved_mm();
  state.dimple_from_mm = state.kernel_moved_mm;  // A membrane met here is not stretched yet.
  PlaceTip(state, axial);
  state.tip_offset_mm += before_mm - moved_mm();
  const ContactPlace& place = state.contact.slot_place(0);
  state.kernel_moved_mm = state.dimple_from_mm =
      axial.dot(system_.DisplacementMm(state.contact, place) + StrainMovedMm(state, place));
}

/// The skin has yielded: from now on there are points along the shaft.
void FemNeedleModel::Enter(FemNeedleState& state, const Eigen::Vector3d& axis) const noexcept {
  state.phase = NeedlePhase::kInside;
  state.frame = FrameAlong(axis);
  state.depth_mm = (state.tip_in_ct_mm - state.entry_mm).dot(axis);
  state.pace = {};
  state.pace_logs = {};
  state.slid_mm = 0.0;
  system_.Restart(state.contact, state.frame);
  AppendPoint(state, 0.0);
  PlaceTip(state, axis);
}

void FemNeedleModel::Demand(FemNeedleState& state) const noexcept {
  const Eigen::Vector3d axial = state.frame.col(2);
  state.depth_mm = (state.tip_in_ct_mm - state.entry_mm).dot(axial);
  for (int p = 0; p < state.contact.num_points(); ++p) {
    const NeedlePoint& point = state.point[static_cast<std::size_t>(p)];
    // On the needle's line at the depth where the point was after the last step.
    const Eigen::Vector2d lateral_mm =
        LineMm(state, point.axial_mm + point.moved_mm) - point.lateral_mm - point.offset_mm;
    state.contact.SetLateral(p, lateral_mm.x(), lateral_mm.y());
    const double friction_n = FrictionNPerMm(state, point) * FrictionLengthMm(state, p);
    state.contact.SetPointAxial(p, state.depth_mm - point.slip_mm, -friction_n, friction_n);
  }
  const double end_mm = (state.end_mm - state.entry_mm).dot(axial);
  DemandTip(state, state.depth_mm - end_mm - state.tip_offset_mm);
}

/// Sets what friction can hold in this step.
void FemNeedleModel::FollowPace(FemNeedleState& state, double dt_s) const noexcept {
  if (!table_.HasTime()) return;
  const double depth_mm = (state.tip_in_ct_mm - state.entry_mm).dot(state.frame.col(2));
  state.pace_logs = forces::StepPace(state.pace, table_.friction_time,
                                     {depth_mm - state.depth_mm, state.slid_mm, dt_s});
}

double FemNeedleModel::FrictionNPerMm(const FemNeedleState& state,
                                      const NeedlePoint& point) const noexcept {
  if (!table_.HasTime()) return point.friction_n_per_mm;
  return point.friction_n_per_mm *
         forces::FrictionShare(table_.tissue[point.tissue].time, state.pace_logs);
}

/// The return map: a point that slipped sticks, from now on, where it slipped to.
void FemNeedleModel::FollowSlip(FemNeedleState& state) const noexcept {
  double slid_mm = 0.0;
  for (int p = 0; p < state.contact.num_points(); ++p) {
    NeedlePoint& point = state.point[static_cast<std::size_t>(p)];
    if (state.contact.PointStatus(p) != ContactStatus::kStick) {
      point.slip_mm -= state.contact.PointExcessMm(p);
      slid_mm -= state.contact.PointExcessMm(p);
    }
    point.moved_mm = state.depth_mm - point.slip_mm;
  }
  state.slid_mm = slid_mm / std::max(1, state.contact.num_points());
}

/// Drops the points that the tip has been withdrawn past.
void FemNeedleModel::DropPoints(FemNeedleState& state) const noexcept {
  int count = state.contact.num_points();
  while (count > 0) {
    const NeedlePoint& last = state.point[static_cast<std::size_t>(count - 1)];
    if (state.depth_mm >= last.axial_mm + last.moved_mm) break;
    --count;
  }
  system_.TruncatePoints(state.contact, count);
}

/// A tip at its limit whose requested depth is larger has cut on, up to where something stops it.
forces::NeedleEvent FemNeedleModel::Cut(FemNeedleState& state) const noexcept {
  forces::NeedleEvent event = forces::NeedleEvent::kNone;
  if (state.membrane_n > 0.0 || state.end_is_bone) return event;
  if (state.contact.SlotStatus(0) == ContactStatus::kStick) return event;
  if (state.contact.SlotForceN(0) < TipLimitN(state) * (1.0 - 1e-9)) return event;
  const double slip_mm = std::min(-state.contact.SlotExcessMm(0), kMostNewPoints * spacing_mm_);
  if (!(slip_mm > 0.0)) return event;

  const int last = state.contact.num_points() - 1;
  const double end_axial_mm = (state.end_mm - state.entry_mm).dot(state.frame.col(2)) + slip_mm;
  const Eigen::Vector2d lateral_mm =
      LineMm(state, state.depth_mm) -
      Eigen::Vector2d(state.contact.LateralMm(2 * last), state.contact.LateralMm(2 * last + 1));
  const Eigen::Vector3d from = state.end_mm;
  const Eigen::Vector3d to =
      state.entry_mm + state.frame * Eigen::Vector3d(lateral_mm.x(), lateral_mm.y(), end_axial_mm);
  const int num_marches = static_cast<int>(std::ceil((to - from).norm() / kMarchMm));
  for (int m = 1; m <= std::min(num_marches, 64); ++m) {
    Eigen::Vector3d beyond = from + (to - from) * (static_cast<double>(m) / num_marches);
    const volume::Label label = mesh_.Find(beyond).tissue;
    if (label == state.end_tissue) {
      state.end_mm = beyond;
      continue;
    }
    Eigen::Vector3d before = state.end_mm;
    for (int h = 0; h < kHalvings; ++h) {
      const Eigen::Vector3d middle = 0.5 * (before + beyond);
      (mesh_.Find(middle).tissue == state.end_tissue ? before : beyond) = middle;
    }
    const bool bone = table_.tissue[label].impenetrable;
    const bool membrane = table_.HasMembrane(state.end_tissue, label);
    state.end_mm = bone || membrane ? before : beyond;
    if (bone) {
      state.end_is_bone = true;
      PlaceTipKeepingForce(state);
      return event;
    }
    event = forces::NeedleEvent::kInterface;
    state.beyond = label;
    if (membrane) {
      state.membrane_n = table_.tissue[label].membrane.puncture_n;
      PlaceTipKeepingForce(state);
      return event;
    }
    state.end_tissue = label;
  }
  // Its row of A is the most expensive part of a step, and hardly changes over a small part of the
  // ball.
  if ((state.end_mm - state.placed_mm).norm() > kReplaceMm) PlaceTip(state, state.frame.col(2));
  return event;
}

/// Sets the points that are due behind the tip: in the fresh cut, or in the old one.
void FemNeedleModel::SetPoints(FemNeedleState& state) const noexcept {
  for (int n = 0; n < kMostNewPoints; ++n) {
    const NeedlePoint& last = state.point[static_cast<std::size_t>(state.contact.num_points() - 1)];
    const double next_mm = last.axial_mm + spacing_mm_;
    const double end_mm = (state.end_mm - state.entry_mm).dot(state.frame.col(2));
    if (std::min(end_mm, state.depth_mm - last.moved_mm) < next_mm) return;
    if (state.contact.num_points() == max_points_) {
      ++state.num_without_point;
      return;
    }
    AppendPoint(state, next_mm);
  }
}

void FemNeedleModel::AppendPoint(FemNeedleState& state, double axial_mm) const noexcept {
  const int n = state.contact.num_points();
  NeedlePoint point;
  point.axial_mm = axial_mm;
  double share = 0.0;  // Of the friction limit, as at the point before.
  if (n > 0) {
    const NeedlePoint& last = state.point[static_cast<std::size_t>(n - 1)];
    const Eigen::Vector2d last_moved_mm(state.contact.LateralMm(2 * n - 2),
                                        state.contact.LateralMm(2 * n - 1));
    point.lateral_mm = LineMm(state, axial_mm + last.moved_mm) - last_moved_mm;
    const double limit_n = FrictionNPerMm(state, last) * FrictionLengthMm(state, n - 1);
    if (limit_n > 0.0) {
      share = std::clamp(state.contact.PointForceN(n - 1)[2] / limit_n, -1.0, 1.0);
    }
  }
  point.rest_in_ct_mm =
      state.entry_mm +
      state.frame * Eigen::Vector3d(point.lateral_mm.x(), point.lateral_mm.y(), axial_mm);
  const Spot spot = mesh_.Find(point.rest_in_ct_mm);
  const std::size_t index = static_cast<std::size_t>(n);
  if (n < state.num_channel) {
    const Eigen::Vector3d aside =
        state.frame.transpose() * (point.rest_in_ct_mm - state.channel_mm[index]);
    if (aside.head<2>().norm() > kChannelMm) {  // Not the old cut: a new one begins here.
      state.num_channel = n;
      state.end_mm = point.rest_in_ct_mm;
      state.end_tissue = spot.tissue;
      state.membrane_n = state.tip_offset_mm = 0.0;
      state.end_is_bone = state.on_bone = false;
      PlaceTip(state, state.frame.col(2));
    }
  }
  if (n >= state.num_channel) {
    state.channel_mm[index] = point.rest_in_ct_mm;
    state.num_channel = n + 1;
  }

  LocalCompliance local{kNothingMmPerN, kNothingMmPerN};
  if (spot.inside) {
    local = ShaftCompliance(whole_[spot.tissue], spot.element_mm, radius_mm_, spacing_mm_);
    if (!spot.reachable) ++state.num_out_of_reach;
  }
  point.friction_n_per_mm = table_.tissue[spot.tissue].friction_n_per_mm;
  point.tissue = spot.tissue;
  const Eigen::Vector3d moved_mm = system_.AppendPoint(state.contact, spot.place, local) +
                                   state.frame.transpose() * StrainMovedMm(state, spot.place);
  const Eigen::Vector3d axial = state.frame.col(2);
  const double own_mm_per_n =
      axial.dot(system_.Between(spot.place, spot.place) * axial) + local.axial_mm_per_n;
  // Friction continues as at the point before, so that a sliding needle does not feel the points.
  const double begin_n = share * 0.5 * spacing_mm_ * FrictionNPerMm(state, point);
  point.moved_mm = moved_mm[2];
  point.slip_mm = state.depth_mm - moved_mm[2] - own_mm_per_n * begin_n;
  point.offset_mm =
      LineMm(state, axial_mm + point.moved_mm) - point.lateral_mm - moved_mm.head<2>();
  state.point[index] = point;
  state.contact.SetLateral(n, moved_mm[0], moved_mm[1]);
  state.contact.SetPointAxial(n, moved_mm[2], 0.0, 0.0);
}

/// The needle has tilted so far that forces along the old frame would be wrong: the same contact in
/// the frame of the needle as it is now.
void FemNeedleModel::Turn(FemNeedleState& state) const noexcept {
  ++state.num_turned;
  const int count = state.contact.num_points();
  const Eigen::Matrix3d old = state.frame;
  state.frame = FrameAlong(state.axis_in_ct);
  state.depth_mm = (state.tip_in_ct_mm - state.entry_mm).dot(state.frame.col(2));
  for (int p = 0; p < count; ++p) {
    NeedlePoint& point = state.point[static_cast<std::size_t>(p)];
    const Eigen::Vector3d moved_mm =
        state.frame.transpose() *
        (old * Eigen::Vector3d(state.contact.LateralMm(2 * p), state.contact.LateralMm(2 * p + 1),
                               point.moved_mm));
    const Eigen::Vector3d rest_mm =
        state.frame.transpose() * (point.rest_in_ct_mm - state.entry_mm);
    point.axial_mm = rest_mm.z();
    point.lateral_mm = rest_mm.head<2>();
    point.moved_mm = moved_mm.z();
    point.slip_mm = state.depth_mm - point.moved_mm;
    point.offset_mm =
        LineMm(state, point.axial_mm + point.moved_mm) - point.lateral_mm - moved_mm.head<2>();
  }
  system_.Restart(state.contact, state.frame);
  for (int p = 0; p < count; ++p) {
    system_.AppendPoint(state.contact, state.contact.point_place(p), state.contact.point_local(p));
  }
  PlaceTip(state, state.frame.col(2));
}

}  // namespace acus::tissue
