#include "acus/scene/effects/fluid/fluid_stage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/scene/effects/fluid/layer_normal.h"
#include "acus/scene/effects/ports.h"

namespace acus::effects {
namespace {

using Eigen::Vector3d;

constexpr double kLongestStepS = 1.0;
constexpr double kShortestStepS = 1e-6;
constexpr double kLeastDepotMl = 0.02;
/// Speed at which a thumb no longer presses, as no hand follows a yielding plunger with its whole
/// force. Estimate.
constexpr double kThumbMmPerS = 10.0;
/// What draws a stylet out of the hub, and pushes it in again. Estimate.
constexpr double kStyletN = 1.0;
/// Behind a ligament, label maps have voxels of soft tissue for so long before epidural fat.
constexpr double kCoarseLabelsMm = 2.0;
constexpr double kTapDuty = 0.4;  ///< Share of a tap's period in which the thumb presses.

/// Fluid of a cavity against the speckle of tissue; the floor of the probe's range is reached.
constexpr double kFluidDb = -40.0;
constexpr double kEdgeMm = 0.6;  ///< Over which a depot's edge fades.
/// Attenuation of tissue, one way; that of fluid is negligible.
constexpr double kTissueDbPerCmMhz = 0.5;
constexpr double kMostEnhancementDb = 8.0;
constexpr double kBubbleDb = 25.0;
constexpr double kShadowDb = -30.0;
constexpr double kLeastShadowAirMl = 0.05;

std::array<double, 3> ArrayOf(const Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}
Vector3d VectorOf(const std::array<double, 3>& a) {
  return Vector3d::Map(a.data());
}

/// A vector from the depot's centre in units of its radii: of length 1 at its surface.
Vector3d ScaledToDepot(const ShownDepot& depot, const Vector3d& v) noexcept {
  const Vector3d normal = VectorOf(depot.normal_in_ct);
  const double across = v.dot(normal);
  return (v - across * normal) / depot.width_radius_mm +
         across / depot.thickness_radius_mm * normal;
}

/// Length of a beam inside the ellipsoid, up to a place, and how far inside the place is: below 1
/// inside.
struct DepotCrossing {
  double inside = 2.0;
  double length_before_mm = 0.0;
};

DepotCrossing CrossingOf(const ShownDepot& depot, const EchoPlace& place) noexcept {
  const Vector3d p = ScaledToDepot(depot, place.place_in_ct_mm - VectorOf(depot.centre_in_ct_mm));
  const Vector3d d = ScaledToDepot(depot, place.beam_in_ct);
  DepotCrossing out{.inside = p.norm()};
  // |p - s d| = 1 for s in mm back along the beam.
  const double a = d.squaredNorm();
  const double b = p.dot(d);
  const double root = b * b - a * (p.squaredNorm() - 1.0);
  if (root <= 0.0) return out;
  const double near = std::clamp((b - std::sqrt(root)) / a, 0.0, place.depth_mm);
  const double far = std::clamp((b + std::sqrt(root)) / a, 0.0, place.depth_mm);
  out.length_before_mm = far - near;
  return out;
}

}  // namespace

FluidStageState FluidStage::Begin() const noexcept {
  FluidStageState state;
  state.fluid = model_->NewState(settings_.hub);
  state.hub = settings_.hub;
  return state;
}

int FluidStage::RowAt(FluidStageState& state, volume::Label label, const Vector3d& tip_mm,
                      const Vector3d& axis_in_ct) const noexcept {
  const FluidRows& rows = settings_.rows;
  const bool was_in_canal = state.is_in_canal;
  const double beyond_ligament_mm = (tip_mm - VectorOf(state.ligament_mm)).dot(axis_in_ct);
  const bool enters_fat_behind_ligament =
      label == rows.fat && state.has_met_ligament && beyond_ligament_mm >= 0.0 &&
      beyond_ligament_mm < kCoarseLabelsMm && state.label != rows.fat;
  const double behind_mm = (tip_mm - VectorOf(state.canal_entry_mm)).norm();
  const bool is_before_canal = was_in_canal && label != rows.ligament && label != rows.bone &&
                               behind_mm < settings_.epidural_depth_mm;
  state.is_in_canal =
      label != 0 && (label == rows.canal || enters_fat_behind_ligament || is_before_canal);
  state.label = label;
  if (label == rows.ligament) {
    state.has_met_ligament = true;
    state.ligament_mm = ArrayOf(tip_mm);
  }
  if (!state.is_in_canal) return rows.of_label[label];
  if (!was_in_canal) state.canal_entry_mm = ArrayOf(tip_mm);
  const double travelled_mm = (tip_mm - VectorOf(state.canal_entry_mm)).norm();
  return travelled_mm < settings_.epidural_depth_mm ? rows.epidural : rows.subarachnoid;
}

double FluidStage::ThumbN(const FluidStageState& state, double session_n,
                          double session_s) const noexcept {
  if (settings_.thumb == Thumb::kSession) return session_n;
  const bool waits = settings_.presses_from_ligament && !state.has_met_ligament;
  if (state.row == 0 || waits) return 0.0;
  const bool is_eased =
      state.is_lost && state.injected_ml - state.injected_at_loss_ml >= settings_.eased_after_ml;
  if (is_eased) return 0.0;
  const double cycles = session_s * settings_.taps_per_s;
  const bool is_between_taps =
      settings_.thumb == Thumb::kTaps && cycles - std::floor(cycles) >= kTapDuty;
  return is_between_taps ? 0.0 : settings_.thumb_n;
}

void FluidStage::MoveStylet(FluidStageState& state, double session_n) const noexcept {
  if (settings_.hub != fluid::Hub::kStylet) return;
  if (state.hub == fluid::Hub::kStylet && session_n <= -kStyletN) {
    state.hub = fluid::Hub::kOpen;
    ++state.stylet_removals;
  } else if (session_n >= kStyletN) {
    state.hub = fluid::Hub::kStylet;
  }
}

void FluidStage::Count(FluidStageState& state, int row, const Vector3d& tip_mm) const noexcept {
  if (row != state.row) {
    if (row == settings_.rows.subarachnoid) ++state.dural_punctures;
    if (row == settings_.rows.vessel) ++state.vessel_entries;
  }
  state.row = row;
  if (state.events.lost_resistance) {
    const bool is_true = row == settings_.rows.epidural;
    ++(is_true ? state.losses : state.false_losses);
    state.is_lost = true;
    state.loss_tip_mm = ArrayOf(tip_mm);
    state.injected_at_loss_ml = state.injected_ml;
  }
}

Vector3d FluidStage::NormalAt(const Vector3d& place_in_ct_mm,
                              const Vector3d& axis_in_ct) const noexcept {
  if (settings_.layers == nullptr) return axis_in_ct;
  return LayerNormal(*settings_.layers, index_from_ct_, place_in_ct_mm).value_or(axis_in_ct);
}

void FluidStage::KeepDepots(FluidStageState& state, const Vector3d& axis_in_ct) const noexcept {
  const auto before = state.depot;
  const auto end = before.begin() + state.num_depots;
  state.num_depots = 0;
  const auto& tissues = model_->table().tissues;
  for (std::size_t row = 1; row < tissues.size() && state.num_depots < kMostShownDepots; ++row) {
    const fluid::TissueFluid& there = state.fluid.tissue[row];
    if (there.liquid_ml + there.air_ml < kLeastDepotMl) continue;
    const fluid::Depot depot = fluid::DepotOf(tissues[row], there);
    ShownDepot& shown = state.depot[static_cast<std::size_t>(state.num_depots++)];
    const auto kept =
        std::find_if(before.begin(), end, [&](const auto& d) { return d.row == row; });
    shown.row = row;
    shown.normal_in_ct =
        kept == end ? ArrayOf(NormalAt(VectorOf(there.centre_mm), axis_in_ct)) : kept->normal_in_ct;
    shown.centre_in_ct_mm = there.centre_mm;
    shown.width_radius_mm = depot.width_radius_mm;
    shown.thickness_radius_mm = depot.thickness_radius_mm;
    const double displaced_mm3 = 1000.0 * std::max(0.0, depot.liquid_ml + depot.air_ml);
    shown.displaced_radius_mm = std::cbrt(0.75 * displaced_mm3 / std::numbers::pi);
    shown.wet_share = depot.wet_share;
    shown.air_ml = depot.air_ml;
  }
}

Activity FluidStage::Step(FluidStageState& state, const StepTime& time, PortValues& ports,
                          std::span<double> columns) const noexcept {
  const Eigen::Isometry3d& needle = ports.Get(ports::kNeedle).ct_from_tool;
  const double dt_s = state.is_started
                          ? std::clamp(time.session_s - state.last_s, kShortestStepS, kLongestStepS)
                          : kShortestStepS;
  state.is_started = true;
  state.last_s = time.session_s;
  if (!needle.matrix().allFinite()) return Activity::kIdle;
  const Vector3d tip_mm = needle.translation();
  const Vector3d axis = needle.linear().col(2).normalized();
  const int row = RowAt(state, ports.Get(ports::kTissue), tip_mm, axis);
  const double session_n = ports.Get(ports::kPlungerForce);
  MoveStylet(state, session_n);
  state.thumb_n = ThumbN(state, session_n, time.session_s);
  fluid::FluidInput input{.hub = state.hub,
                          .hand_n = state.thumb_n,
                          .coupling_n_s_per_mm = std::abs(state.thumb_n) / kThumbMmPerS,
                          .tip_mm = tip_mm,
                          .heart_cycles = settings_.heart_per_s * time.session_s};
  input.bevel[0] = {row, 1.0};
  const fluid::FluidOutput out = model_->Step(state.fluid, input, dt_s);
  state.injected_ml += std::max(0.0, out.flow_ml_per_s) * dt_s;
  if (state.hub == fluid::Hub::kSyringe) {
    state.aspirated_ml += std::max(0.0, -out.flow_ml_per_s) * dt_s;
  }
  state.events.Advance(limits_, out, dt_s);
  Count(state, row, tip_mm);
  state.beyond_loss_mm = state.is_lost ? (tip_mm - VectorOf(state.loss_tip_mm)).dot(axis) : 0.0;
  state.force_in_ct_n = ArrayOf(out.barrel_n * axis);
  KeepDepots(state, axis);

  const auto write = [&columns](FluidColumn column, double value) {
    columns[static_cast<std::size_t>(column)] = value;
  };
  write(FluidColumn::kPlungerN, state.thumb_n);
  write(FluidColumn::kPlungerMm, out.plunger_mm);
  write(FluidColumn::kSyringeKpa, out.syringe_kpa);
  write(FluidColumn::kBevelKpa, out.bevel_kpa);
  write(FluidColumn::kFlowMlPerMin, 60.0 * out.flow_ml_per_s);
  write(FluidColumn::kInjectedMl, state.injected_ml);
  write(FluidColumn::kReturnedMl, state.fluid.hub_ml);
  write(FluidColumn::kDropsPerMin, state.events.drops_per_min);
  write(FluidColumn::kBeyondLossMm, state.beyond_loss_mm);
  write(FluidColumn::kLosses, state.losses);
  write(FluidColumn::kFalseLosses, state.false_losses);
  write(FluidColumn::kDuralPunctures, state.dural_punctures);
  write(FluidColumn::kVesselEntries, state.vessel_entries);
  write(FluidColumn::kAspiratedMl, state.aspirated_ml);
  const auto& space = state.fluid.tissue[static_cast<std::size_t>(settings_.rows.space)];
  write(FluidColumn::kSpaceMl, space.liquid_ml + space.absorbed_ml + space.air_ml);
  write(FluidColumn::kStyletRemovals, state.stylet_removals);
  return row == 0 && state.thumb_n == 0.0 ? Activity::kIdle : Activity::kActive;
}

Vector3d FluidStage::ForceInCtN(const FluidStageState& state) const noexcept {
  return VectorOf(state.force_in_ct_n);
}

Vector3d FluidStage::RestInCtMm(const FluidStageState& state,
                                const Vector3d& place_in_ct_mm) const noexcept {
  Vector3d rest_mm = place_in_ct_mm;
  for (int n = 0; n < state.num_depots; ++n) {
    const ShownDepot& depot = state.depot[static_cast<std::size_t>(n)];
    const Vector3d from_centre_mm = rest_mm - VectorOf(depot.centre_in_ct_mm);
    const double s = ScaledToDepot(depot, from_centre_mm).norm();
    if (!(s > 0.0) || !std::isfinite(s)) continue;
    // Ellipsoidal shells keep their volume: s^3 less the displaced share of the depot.
    const double share = std::pow(depot.displaced_radius_mm, 3) /
                         (std::pow(depot.width_radius_mm, 2) * depot.thickness_radius_mm);
    const double rest_s = std::cbrt(std::max(std::pow(s, 3) - share, 0.0));
    rest_mm = VectorOf(depot.centre_in_ct_mm) + rest_s / s * from_centre_mm;
  }
  return rest_mm;
}

bool FluidStage::IsSameMotion(const FluidStageState& a, const FluidStageState& b) const noexcept {
  if (a.num_depots != b.num_depots) return false;
  for (int n = 0; n < a.num_depots; ++n) {
    const ShownDepot& p = a.depot[static_cast<std::size_t>(n)];
    const ShownDepot& q = b.depot[static_cast<std::size_t>(n)];
    if (p.centre_in_ct_mm != q.centre_in_ct_mm || p.normal_in_ct != q.normal_in_ct ||
        p.width_radius_mm != q.width_radius_mm || p.thickness_radius_mm != q.thickness_radius_mm ||
        p.displaced_radius_mm != q.displaced_radius_mm || p.wet_share != q.wet_share ||
        p.air_ml != q.air_ml) {
      return false;
    }
  }
  return true;
}

double FluidStage::EchoChangeDb(const FluidStageState& state,
                                const EchoPlace& place) const noexcept {
  double change_db = 0.0;
  for (int n = 0; n < state.num_depots; ++n) {
    const ShownDepot& depot = state.depot[static_cast<std::size_t>(n)];
    const DepotCrossing crossing = CrossingOf(depot, place);
    const double edge = kEdgeMm / depot.thickness_radius_mm;
    const double inside = std::clamp(0.5 + (1.0 - crossing.inside) / edge, 0.0, 1.0);
    const bool has_air = depot.air_ml >= kLeastShadowAirMl;
    if (inside > 0.0) {
      change_db += inside * (has_air ? kBubbleDb : depot.wet_share * kFluidDb);
    } else if (crossing.length_before_mm > 0.0) {
      const double spared_db = 0.2 * kTissueDbPerCmMhz * place.frequency_mhz *
                               crossing.length_before_mm * depot.wet_share;
      change_db += has_air ? kShadowDb : std::min(spared_db, kMostEnhancementDb);
    }
  }
  return change_db;
}

}  // namespace acus::effects
