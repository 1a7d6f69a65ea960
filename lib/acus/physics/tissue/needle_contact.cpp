#include "acus/physics/tissue/needle_contact.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/physics/tissue/needle_contact_limits.h"

namespace acus::tissue {
namespace {

constexpr double kFarthestTipMm = 1e5;      // A probe beyond it is not in a room.
constexpr double kLongestSearchMm = 400.0;  // From inside the body back to the skin.
constexpr double kSamePlaceMm = 0.1;    // On the skin; the tip's compliance is found again beyond.
constexpr double kSameCosine = 0.9998;  // 1 degree.
constexpr double kReentryMm = 1.0;      // So near the old entry, the tip finds the channel again.
constexpr double kReentryCosine = 0.996;  // And with less than 5 degrees to it.

bool IsPosition(const Eigen::Vector3d& x_mm) {
  return x_mm.allFinite() && x_mm.cwiseAbs().maxCoeff() <= kFarthestTipMm;
}

}  // namespace

FemNeedleModel::FemNeedleModel(const mesh::TetraMesh& mesh, const mechanics::Compliance& compliance,
                               const mechanics::ElasticityTable& elasticity,
                               const forces::ForceTable& table,
                               const forces::NeedleProperties& needle,
                               const FemContactSettings& settings)
    : table_(table.ScaledTo(needle.beam.outer_diameter_mm)),
      membranes_(elasticity.membranes),
      mesh_(mesh, compliance),
      kernel_(mesh, compliance),
      max_points_(settings.max_points),
      system_(compliance,
              {.points = settings.max_points,
               .slots = 1 + (settings.probe ? settings.max_probe_nodes : 0)},
              elasticity.relaxation),
      radius_mm_(0.5 * needle.beam.outer_diameter_mm),
      spacing_mm_(std::max(settings.contact_spacing_mm,
                           needle.length_mm / std::max(settings.max_points - 1, 1))) {
  ACUS_REQUIRE(compliance.num_nodes() > 0, "the compliance has no node that a tool can reach");
  ACUS_REQUIRE(settings.contact_spacing_mm > 0.0 && std::isfinite(settings.contact_spacing_mm),
               "contact_spacing_mm must be more than 0, got ", settings.contact_spacing_mm);
  ACUS_REQUIRE(settings.max_points >= 2 && settings.max_points <= 128,
               "the number of contact points must be 2 to 128, got ", settings.max_points);
  ACUS_REQUIRE(radius_mm_ > 0.0, "the needle has no diameter");
  for (Eigen::Index t = 0; t < mesh.tetrahedra.cols(); ++t) {
    bool moves = false;
    for (int c = 0; c < 4; ++c) {
      moves = moves || mesh.fixed_nodes[static_cast<std::size_t>(mesh.tetrahedra(c, t))] == 0;
    }
    const volume::Label label = mesh.tissue[static_cast<std::size_t>(t)];
    if (!moves || elastic_[label].youngs_modulus_mpa > 0.0) continue;
    elastic_[label] = elasticity.SolidAt(label);
    whole_[label] = elasticity.At(label);
    if (const mechanics::Membrane* membrane = elasticity.MembraneOf(label, 0)) {
      skin_shell_[label].emplace(*membrane, elastic_[label], radius_mm_);
    }
  }
  for (auto* tissues : {&elastic_, &whole_}) {
    for (mechanics::ElasticTissue& tissue : *tissues) {
      if (tissue.youngs_modulus_mpa <= 0.0) tissue = {kRigidMpa, 0.3};  // Held still by its nodes.
    }
  }
  if (settings.probe) {
    probe_.emplace(ReachableSurface(mesh, compliance), *settings.probe, 1,
                   settings.max_probe_nodes);
  }
  if (settings.strain) strain_.emplace(mesh, elasticity, compliance, *settings.strain);
}

FemNeedleState FemNeedleModel::NewState() const {
  FemNeedleState state;
  state.contact = system_.NewState();
  if (probe_) state.probe = probe_->NewState();
  if (strain_) state.strain = strain_->NewState();
  state.point.resize(static_cast<std::size_t>(max_points_));
  state.channel_mm.resize(static_cast<std::size_t>(max_points_), Eigen::Vector3d::Zero());
  return state;
}

/// What happened in a step.
struct FemNeedleModel::Outcome {
  forces::NeedleEvent event = forces::NeedleEvent::kNone;
  double tip_n = 0.0;
  void Happened(forces::NeedleEvent what) { event = FirstOf(event, what); }
};

forces::NeedleForce FemNeedleModel::Step(FemNeedleState& state,
                                         const ToolSample& sample) const noexcept {
  const bool is_later =
      std::isfinite(sample.time_s) && !(state.started && sample.time_s <= state.time_s);
  const SampleGate::Verdict verdict = state.Judge(sample);
  if (is_later) {
    system_.Pass(state.contact, state.started ? sample.time_s - state.passed_s : 0.0);
    state.passed_s = sample.time_s;
    StepProbe(state, sample);
  }
  if (verdict != SampleGate::Verdict::kStep) {
    if (is_later && probe_) {  // The needle stays where it was; the probe continues.
      if (state.phase == NeedlePhase::kInside) Demand(state);
      SolveContact(state);
      if (state.phase != NeedlePhase::kFree) FollowDimple(state);
      if (state.phase == NeedlePhase::kInside) FollowSlip(state);
      state.probe_force = probe_->ForceOf(state.contact, state.probe);
    }
    return verdict == SampleGate::Verdict::kHold ? state.Held(table_.settings)
                                                 : forces::NeedleForce{};
  }

  Outcome outcome;
  state.axis_in_ct = sample.axis_in_ct.normalized();
  state.tip_in_ct_mm = sample.tip_in_ct_mm;
  if (state.phase != NeedlePhase::kInside) {
    Touch(state, sample.tip_in_ct_mm, state.axis_in_ct, outcome);
  }
  if (state.phase == NeedlePhase::kInside) {
    FollowPace(state, state.started ? sample.time_s - state.valid_time_s : 1.0);
    Demand(state);
  } else if (state.phase == NeedlePhase::kOnSkin) {
    PressSkin(state);
  }
  SolveContact(state);
  if (state.phase != NeedlePhase::kFree) {
    FollowDimple(state);
    const bool is_off = state.contact.SlotStatus(0) == ContactStatus::kAtLow;
    outcome.tip_n = is_off ? 0.0 : std::max(0.0, state.contact.SlotForceN(0));
    // The dimple that the step ends with presses a little more than the one it was solved for.
    if (state.dimple.stretching_n_per_mm > 0.0) {
      outcome.tip_n = std::min(outcome.tip_n, TipLimitN(state));
    }
  }
  forces::NeedleForce out = ForceOf(state, outcome);
  After(state, outcome);
  out.event = outcome.event;
  if (probe_) state.probe_force = probe_->ForceOf(state.contact, state.probe);
  state.Accept(sample, out);
  return out;
}

/// Finds all forces for what is demanded of the contact; nothing to do if no tool can touch.
void FemNeedleModel::SolveContact(FemNeedleState& state) const noexcept {
  const bool can_touch = state.phase != NeedlePhase::kFree || probe_.has_value();
  if (strain_) {
    can_touch ? strain_->Solve(system_, state.contact, state.strain)
              : strain_->Forget(state.strain);
  } else if (can_touch) {
    system_.Solve(state.contact);
  }
}

/// Displacement of a place outside the contact, CT axes: of tissue at large strain.
Eigen::Vector3d FemNeedleModel::StrainMovedMm(const FemNeedleState& state,
                                              const ContactPlace& place) const noexcept {
  return strain_ ? strain_->MovedMm(state.strain, place) : Eigen::Vector3d::Zero();
}

void FemNeedleModel::StepProbe(FemNeedleState& state, const ToolSample& sample) const noexcept {
  if (!probe_) return;
  const bool good = sample.probe_valid && sample.ct_from_probe.matrix().allFinite() &&
                    IsPosition(sample.ct_from_probe.translation());
  if (good) {
    probe_->Place(system_, state.contact, state.probe, sample.ct_from_probe);
    state.probe_time_s = sample.time_s;
  } else if (sample.time_s - state.probe_time_s > table_.settings.invalid_hold_s) {
    probe_->Lift(system_, state.contact, state.probe);
  }
}

/// Looks for the skin between the last place outside and the tip, or where it is pressed already.
void FemNeedleModel::Touch(FemNeedleState& state, const Eigen::Vector3d& tip_mm,
                           const Eigen::Vector3d& axis, Outcome& outcome) const noexcept {
  if (!mesh_.Find(tip_mm).inside) {
    if (state.phase == NeedlePhase::kOnSkin) Release(state);
    state.has_previous = true;
    state.outside_mm = tip_mm;
    return;
  }
  std::optional<Eigen::Vector3d> outside;
  if (state.phase == NeedlePhase::kFree && state.has_previous) {
    outside = state.outside_mm;
  } else if (state.phase == NeedlePhase::kOnSkin || !state.started) {
    // Back along the needle: pressed skin moves with the tip; or the session begins inside.
    for (double back_mm = 1.0; back_mm < kLongestSearchMm && !outside; back_mm *= 1.5) {
      const Eigen::Vector3d behind = tip_mm - back_mm * axis;
      if (!mesh_.Find(behind).inside) outside = behind;
    }
  }
  if (!outside) return;  // Given up inside: it must leave first.
  const bool is_new = state.phase == NeedlePhase::kFree;
  const Eigen::Vector3d at = mesh_.Crossing(*outside, tip_mm);
  state.has_previous = false;
  if (is_new) {
    outcome.Happened(forces::NeedleEvent::kContact);
    const bool in_channel = state.has_channel && (at - state.entry_mm).norm() < kReentryMm &&
                            axis.dot(state.frame.col(2)) > kReentryCosine;
    if (in_channel) {
      Enter(state, axis);
      return;
    }
    const Spot spot = mesh_.Find(at);
    state.has_channel = false;
    state.num_channel = 0;
    state.end_tissue = spot.tissue;
    state.beyond = spot.tissue;
    state.end_is_bone = table_.tissue[spot.tissue].impenetrable;
    state.membrane_n =
        table_.HasMembrane(0, spot.tissue) ? table_.tissue[spot.tissue].membrane.puncture_n : 0.0;
    state.on_bone = false;
    state.tip_offset_mm = 0.0;
    state.kernel_moved_mm = state.dimple_from_mm = state.ground_mpa = 0.0;
  }
  state.phase = NeedlePhase::kOnSkin;
  state.entry_mm = state.end_mm = at;
  state.frame = FrameAlong(axis);
}

void FemNeedleModel::PressSkin(FemNeedleState& state) const noexcept {
  state.depth_mm = (state.tip_in_ct_mm - state.entry_mm).dot(state.frame.col(2));
  // A membrane's dimple widens with its depth, so that its kernel is placed again in every step.
  const bool same = state.contact.slot_in_use(0) && state.dimple.stretching_n_per_mm <= 0.0 &&
                    (state.end_mm - state.placed_mm).norm() < kSamePlaceMm &&
                    state.contact.slot_direction(0).dot(state.frame.col(2)) > kSameCosine;
  if (!same) PlaceTip(state, state.frame.col(2));
  DemandTip(state, state.depth_mm);
}

void FemNeedleModel::Release(FemNeedleState& state) const noexcept {
  system_.TruncatePoints(state.contact, 0);
  system_.ClearSlot(state.contact, 0);
  state.phase = NeedlePhase::kFree;
  state.on_bone = false;
  state.tip_offset_mm = 0.0;
  state.depth_mm = 0.0;
  state.dimple = {};
}

/// True if the membrane that the tip presses yields, or on the skin, what is there instead.
bool FemNeedleModel::Pierced(FemNeedleState& state, Outcome& outcome) const noexcept {
  if (state.end_is_bone) return false;
  const bool on_skin = state.phase == NeedlePhase::kOnSkin;
  if (state.membrane_n <= 0.0 && !on_skin) return false;
  if (outcome.tip_n < TipLimitN(state) * (1.0 - 1e-9)) return false;
  if (state.membrane_n > 0.0) outcome.Happened(forces::NeedleEvent::kPuncture);
  state.membrane_n = 0.0;
  state.dimple = {};
  state.end_tissue = state.beyond;
  state.tip_offset_mm = 0.0;
  return true;
}

/// From the solution to the state that the next sample finds.
void FemNeedleModel::After(FemNeedleState& state, Outcome& outcome) const noexcept {
  if (state.phase == NeedlePhase::kFree) return;
  if (state.end_is_bone) {
    if (outcome.tip_n > 0.0 && !state.on_bone) outcome.Happened(forces::NeedleEvent::kBoneContact);
    if (outcome.tip_n <= 0.0 && state.on_bone) {
      outcome.Happened(forces::NeedleEvent::kBoneRelease);
    }
    state.on_bone = outcome.tip_n > 0.0;
  }
  if (outcome.tip_n <= 0.0) {
    // Off what it pressed, the offset goes, as far as that does not press again.
    const double room_mm = std::max(0.0, state.contact.SlotExcessMm(0));
    state.tip_offset_mm -= std::min(std::max(state.tip_offset_mm, 0.0), room_mm);
    state.tip_offset_mm = std::max(state.tip_offset_mm, 0.0);
  }
  if (state.phase == NeedlePhase::kOnSkin) {
    if (!Pierced(state, outcome)) return;
    state.has_channel = true;
    Enter(state, state.axis_in_ct);
    return;
  }
  FollowSlip(state);
  const Eigen::Vector3d axial = state.frame.col(2);
  double first_n = 0.0;
  double second_n = 0.0;
  for (int p = 0; p < state.contact.num_points(); ++p) {
    first_n += state.contact.PointForceN(p)[0];
    second_n += state.contact.PointForceN(p)[1];
  }
  const double cosine = state.axis_in_ct.dot(axial);
  if (std::hypot(first_n, second_n) > table_.settings.largest_force_n || cosine < kLeastCosine) {
    Release(state);
    state.has_channel = false;
    state.has_previous = false;  // It must be seen outside before it touches again.
    ++state.num_lost;
    outcome.Happened(forces::NeedleEvent::kWithdrawal);
    return;
  }
  DropPoints(state);
  if (state.contact.num_points() == 0) {
    Release(state);
    state.has_previous = true;
    state.outside_mm = state.entry_mm - kOutsideMm * axial;
    outcome.Happened(forces::NeedleEvent::kWithdrawal);
    return;
  }
  if (!Pierced(state, outcome)) outcome.Happened(Cut(state));
  SetPoints(state);
  if (cosine < kTurnCosine) Turn(state);
}

forces::NeedleForce FemNeedleModel::ForceOf(const FemNeedleState& state,
                                            const Outcome& outcome) const noexcept {
  forces::NeedleForce out;
  if (state.phase == NeedlePhase::kFree) return out;
  out.depth_mm = state.depth_mm;
  Eigen::Vector3d sum_n = Eigen::Vector3d::Zero();
  const double cosine = std::max(state.axis_in_ct.dot(state.frame.col(2)), kLeastCosine);
  for (int p = 0; p < state.contact.num_points(); ++p) {
    const NeedlePoint& point = state.point[static_cast<std::size_t>(p)];
    const Eigen::Vector3d force_n = state.contact.PointForceN(p);
    const double behind_mm = point.axial_mm + point.moved_mm - state.depth_mm;
    const Eigen::Vector3d arm_mm = (behind_mm / cosine) * state.axis_in_ct;
    out.torque_in_ct_n_mm -= arm_mm.cross(state.frame * force_n);
    sum_n += force_n;
  }
  out.friction_n = sum_n[2];
  out.lateral_n = sum_n.head<2>().norm();
  if (state.end_is_bone) {
    out.bone_n = outcome.tip_n;
    out.bone_penetration_mm = outcome.tip_n / table_.settings.bone.stiffness_n_per_mm;
  } else if (state.membrane_n > 0.0) {
    const double cutting_n = table_.tissue[state.end_tissue].cutting_n;
    out.cutting_n = state.phase == NeedlePhase::kOnSkin ? 0.0 : std::min(outcome.tip_n, cutting_n);
    out.puncture_n = outcome.tip_n - out.cutting_n;
  } else {
    out.cutting_n = outcome.tip_n;
  }
  sum_n[2] += outcome.tip_n;
  out.force_in_ct_n = -(state.frame * sum_n);
  LimitTo(out, table_.settings.largest_force_n);
  if (!out.force_in_ct_n.allFinite()) return {};
  return out;
}

void FemNeedleModel::LoadOf(const FemNeedleState& state, TissueLoad& out) const noexcept {
  out.num_points = 0;
  out.needle = {};
  const auto add = [&](const Eigen::Vector3d& rest_mm, const Eigen::Vector3d& force_n) {
    if (out.num_points == TissueLoad::kMaxPoints || force_n.isZero(0.0)) return;
    out.point[static_cast<std::size_t>(out.num_points++)] = {rest_mm, force_n};
  };
  NeedleLoad& needle = out.needle;
  needle.tip_in_ct_mm = state.tip_in_ct_mm;
  needle.axis_in_ct = state.axis_in_ct;
  if (state.phase != NeedlePhase::kFree) {
    needle.in_contact = true;
    needle.pierced = state.phase == NeedlePhase::kInside;
    needle.entry_in_ct_mm = state.entry_mm;
    for (int p = 0; p < state.contact.num_points(); ++p) {
      needle.friction_n += state.contact.PointForceN(p)[2];
      add(state.point[static_cast<std::size_t>(p)].rest_in_ct_mm,
          state.frame * state.contact.ElasticPointN(p));
    }
    const double tip_n = state.contact.SlotForceN(0);
    (state.membrane_n > 0.0 || !needle.pierced ? needle.pre_puncture_n : needle.cutting_n) = tip_n;
    const ContactPlace& tip = state.contact.slot_place(0);
    for (int r = 0; r < tip.num_rows; ++r) {
      const std::size_t at = static_cast<std::size_t>(r);
      add(kernel_.RestOf(tip.row[at]),
          tip.weight[at] * state.contact.ElasticSlotN(0) * state.contact.slot_direction(0));
    }
  }
  for (std::size_t s = 0; s < state.probe.node_of_slot.size(); ++s) {
    if (state.probe.node_of_slot[s] < 0) continue;
    const SurfaceNode& node = probe_->node(state.probe.node_of_slot[s]);
    const int slot = probe_->first_slot() + static_cast<int>(s);
    add(node.rest_in_ct_mm, state.contact.ElasticSlotN(slot) * node.inward_in_ct);
  }
  for (int n = 0; strain_ && n < strain_->region().num_nodes(); ++n) {
    add(strain_->NodeMm(n), strain_->ForceN(state.strain, n));
  }
}

}  // namespace acus::tissue
