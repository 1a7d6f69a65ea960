#include "acus/physics/fluid/fluid_model.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/physics/fluid/plunger_equation.h"

namespace acus::fluid {
namespace {

static_assert(std::is_trivially_copyable_v<FluidState>);

/// Beyond these, an input is an error of the device.
constexpr double kMostHandN = 500.0;
constexpr double kMostMm = 1e4;
constexpr double kMostMmPerS = 1e5;
constexpr double kMostCoupling = 1e6;
constexpr double kLeastStepS = 1e-6;
constexpr double kMostStepS = 10.0;
/// Systole: share of a heart beat until the pressure is highest.
constexpr double kUpstroke = 0.3;
/// Less liquid than this before the air is none.
constexpr double kTraceMl = 1e-9;

double FiniteOr(double value, double otherwise) noexcept {
  return std::isfinite(value) ? value : otherwise;
}

/// Pressure pulse from -0.5 to 0.5, mean 0; lowest at whole numbers.
double PulseShape(double heart_cycles) noexcept {
  const double phase = heart_cycles - std::floor(heart_cycles);
  const double part =
      phase < kUpstroke ? phase / kUpstroke : 1.0 + (phase - kUpstroke) / (1.0 - kUpstroke);
  return -0.5 * std::cos(std::numbers::pi * part);
}

double Within(double value, double low, double high) noexcept {
  return std::min(std::max(value, low), high);
}

/// The same input with every number usable.
FluidInput Usable(const FluidInput& input, const FluidState& state,
                  std::size_t num_tissues) noexcept {
  FluidInput out = input;
  const auto usable = [](double value, double most, double otherwise) {
    return Within(FiniteOr(value, otherwise), -most, most);
  };
  out.hand_n = usable(input.hand_n, kMostHandN, 0.0);
  out.hand_mm = usable(input.hand_mm, kMostMm, state.plunger_mm);
  out.hand_mm_per_s = usable(input.hand_mm_per_s, kMostMmPerS, 0.0);
  out.coupling_n_per_mm = std::max(0.0, usable(input.coupling_n_per_mm, kMostCoupling, 0.0));
  out.coupling_n_s_per_mm = std::max(0.0, usable(input.coupling_n_s_per_mm, kMostCoupling, 0.0));
  for (BevelContact& contact : out.bevel) {
    if (contact.tissue < 0 || contact.tissue >= static_cast<int>(num_tissues)) contact.tissue = 0;
    contact.share = Within(FiniteOr(contact.share, 0.0), 0.0, 1.0);
  }
  out.heart_cycles = usable(input.heart_cycles, 1e12, 0.0);
  out.breath_level = usable(input.breath_level, 10.0, 0.0);
  if (!(input.tip_mm.cwiseAbs().maxCoeff() < kMostMm)) {
    out.tip_mm = Eigen::Vector3d(state.tip_mm[0], state.tip_mm[1], state.tip_mm[2]);
  }
  return out;
}

void RequireUsable(const Syringe& syringe, const Filling& filling, const Lumen& lumen,
                   const FluidOptions& options) {
  ACUS_REQUIRE(syringe.capacity_ml > 0.0 && syringe.bore_mm > 0.0 && syringe.dead_space_ml > 0.0,
               "syringe ", syringe.name, ": capacity, bore and dead space must be above 0");
  ACUS_REQUIRE(syringe.compliance_ml_per_kpa >= 0.0 && syringe.sliding_friction_n >= 0.0 &&
                   syringe.static_friction_n >= syringe.sliding_friction_n &&
                   syringe.viscous_n_s_per_mm >= 0.0,
               "syringe ", syringe.name,
               ": compliance and friction must not be negative, and static_friction_n not below "
               "sliding_friction_n");
  ACUS_REQUIRE(syringe.stick_n_per_mm > 0.0 && syringe.plunger_mass_kg > 0.0 &&
                   syringe.stribeck_speed_mm_per_s > 0.0,
               "syringe ", syringe.name,
               ": stick_n_per_mm, plunger_mass_kg and stribeck_speed_mm_per_s must be above 0");
  ACUS_REQUIRE(filling.volume_ml >= 0.0 && filling.volume_ml <= syringe.capacity_ml,
               "filling: volume_ml is ", filling.volume_ml, "; 0 to ", syringe.capacity_ml,
               ", the syringe's capacity, is allowed");
  ACUS_REQUIRE(filling.air_share >= 0.0 && filling.air_share <= 1.0, "filling: air_share is ",
               filling.air_share, "; 0 to 1 is allowed");
  ACUS_REQUIRE(lumen.inner_diameter_mm > 0.0 && lumen.length_mm > 0.0, "needle: the bore is ",
               lumen.inner_diameter_mm, " mm, its length ", lumen.length_mm,
               " mm; both must be above 0 for fluid to pass");
  ACUS_REQUIRE(lumen.tip_length_mm >= 0.0 && lumen.tip_length_mm < lumen.length_mm &&
                   (lumen.tip_length_mm == 0.0 || lumen.tip_inner_diameter_mm > 0.0),
               "needle: the tapered tip must be shorter than the needle, with a bore above 0");
  ACUS_REQUIRE(options.num_shells >= 2 && options.num_shells <= kMaxShells, "num_shells is ",
               options.num_shells, "; 2 to ", kMaxShells, " is allowed");
}

double RoomMl(const Syringe& syringe, double plunger_mm) noexcept {
  return syringe.capacity_ml + syringe.dead_space_ml - syringe.AreaMlPerMm() * plunger_mm;
}

/// Critical damping of the stopper on the elastic part of its friction.
double StickDampingNSPerMm(const Syringe& syringe) noexcept {
  return 2e-3 * std::sqrt(1e3 * syringe.stick_n_per_mm * syringe.plunger_mass_kg);
}

double YieldN(const Syringe& syringe, double slip_mm_per_s) noexcept {
  return syringe.sliding_friction_n +
         (syringe.static_friction_n - syringe.sliding_friction_n) *
             std::exp(-std::abs(slip_mm_per_s) / syringe.stribeck_speed_mm_per_s);
}

/// How the hand drives the plunger, as a force that falls with the plunger's travel in the step.
void SetDrive(const FluidInput& input, PlungerEquation& equation) noexcept {
  equation.hand_n_s_per_mm = input.coupling_n_s_per_mm;
  if (input.drive == Drive::kForce) {
    equation.hand_n = input.hand_n;
    return;
  }
  equation.hand_n_per_mm = input.coupling_n_per_mm;
  equation.hand_n = input.coupling_n_per_mm * (input.hand_mm - equation.start_mm) +
                    input.coupling_n_s_per_mm * input.hand_mm_per_s;
}

}  // namespace

FluidModel::FluidModel(FluidTable table, Syringe syringe, Filling filling, Lumen lumen,
                       FluidOptions options)
    : table_(std::move(table)),
      syringe_(std::move(syringe)),
      filling_(filling),
      lumen_(lumen),
      options_(options) {
  RequireUsable(syringe_, filling_, lumen_, options_);
  ACUS_REQUIRE(!table_.tissues.empty() && table_.tissues.size() <= kMaxTissues,
               "the fluid table has ", table_.tissues.size(), " tissues; 1 to ", kMaxTissues,
               " are allowed");
  liquid_resistance_ = ResistanceOf(lumen_, table_.saline);
  air_resistance_ = ResistanceOf(lumen_, kAir);
  lumen_ml_ = lumen_.VolumeMl();
  for (const FluidTissue& tissue : table_.tissues) {
    spreads_.emplace_back(tissue.spread_kpa_s_per_ml, tissue.spread_time_s, options_.num_shells);
  }
}

FluidState FluidModel::NewState(Hub hub) const noexcept {
  FluidState state;
  const bool has_liquid = filling_.air_share < 1.0;
  state.hub = hub;
  state.plunger_mm = (syringe_.capacity_ml - filling_.volume_ml) / syringe_.AreaMlPerMm();
  state.liquid_ml =
      filling_.volume_ml * (1.0 - filling_.air_share) + (has_liquid ? syringe_.dead_space_ml : 0.0);
  state.air_ml = RoomMl(syringe_, state.plunger_mm) - state.liquid_ml;
  if (hub == Hub::kSyringe && has_liquid) state.lumen_liquid_ml = lumen_ml_;
  if (hub == Hub::kOpen || (hub == Hub::kSyringe && !has_liquid)) state.lumen_air_ml = lumen_ml_;
  if (filling_.air_share == 0.0) state.air_ml = 0.0;
  return state;
}

double FluidModel::RestingKpa(int tissue, double heart_cycles, double breath_level) const noexcept {
  const FluidTissue& row = table_.tissues[static_cast<std::size_t>(tissue)];
  double kpa = row.resting_kpa + row.breath_kpa * breath_level;
  if (row.pulse_kpa != 0.0) kpa += row.pulse_kpa * PulseShape(heart_cycles);
  return kpa;
}

void FluidModel::ChangeHub(FluidState& state, Hub hub) const noexcept {
  if (hub == state.hub) return;
  if (state.hub == Hub::kSyringe) {  // Taken off: its content comes to atmospheric pressure.
    const double room_ml = std::max(0.0, RoomMl(syringe_, state.plunger_mm));
    const double spilt_ml = std::max(0.0, state.liquid_ml - room_ml);
    state.liquid_ml -= spilt_ml;
    state.hub_ml += spilt_ml;
    const double air_ml = room_ml - state.liquid_ml;
    state.hub_air_ml += air_ml - state.air_ml;
    state.air_ml = air_ml;
    state.plunger_mm_per_s = 0.0;
    state.friction = {};
  }
  if (state.hub == Hub::kStylet) {  // Drawn: air follows it.
    state.lumen_air_ml = lumen_ml_;
    state.hub_air_ml += lumen_ml_;
  }
  if (hub == Hub::kStylet) {
    state.hub_ml += state.lumen_liquid_ml;
    state.hub_air_ml -= state.lumen_air_ml;
    state.lumen_liquid_ml = 0.0;
    state.lumen_air_ml = 0.0;
  }
  state.syringe_kpa = 0.0;
  state.hub = hub;
}

void FluidModel::FollowTip(FluidState& state, const FluidInput& input) const noexcept {
  const Eigen::Vector3d before(state.tip_mm[0], state.tip_mm[1], state.tip_mm[2]);
  const double travel_mm = state.has_tip ? (input.tip_mm - before).norm() : 0.0;
  state.has_tip = true;
  for (int i = 0; i < 3; ++i) state.tip_mm[static_cast<std::size_t>(i)] = input.tip_mm[i];
  // A tissue that the other end of the bevel was in before keeps its pressures.
  const bool is_swapped = input.bevel[0].tissue == state.spread_tissue[1] ||
                          input.bevel[1].tissue == state.spread_tissue[0];
  if (is_swapped && state.spread_tissue[0] != input.bevel[0].tissue) {
    std::swap(state.spread_tissue[0], state.spread_tissue[1]);
    std::swap(state.spread[0], state.spread[1]);
    std::swap(state.available_ml[0], state.available_ml[1]);
  }
  for (std::size_t i = 0; i < input.bevel.size(); ++i) {
    const int tissue = input.bevel[i].share > 0.0 ? input.bevel[i].tissue : 0;
    if (tissue != state.spread_tissue[i]) {
      state.spread_tissue[i] = tissue;
      state.spread[i] = {};
      state.available_ml[i] = 0.0;
    } else if (travel_mm > 0.0) {
      const FluidTissue& row = table_.tissues[static_cast<std::size_t>(tissue)];
      const double kept = std::exp(-travel_mm / row.source_radius_mm);
      for (double& kpa : state.spread[i].kpa) kpa *= kept;
      state.available_ml[i] *= kept;
    }
  }
}

BevelLaw FluidModel::LawAt(const FluidState& state, const FluidInput& input,
                           double dt_s) const noexcept {
  BevelLaw law;
  for (std::size_t i = 0; i < input.bevel.size(); ++i) {
    const BevelContact& contact = input.bevel[i];
    if (contact.share <= 0.0) continue;
    const auto at = static_cast<std::size_t>(contact.tissue);
    const FluidTissue& row = table_.tissues[at];
    const TissueFluid& fluid = state.tissue[at];
    const TissueSpread::Response response = spreads_[at].ResponseOf(state.spread[i], dt_s);
    BevelBranch& branch = law.branch[i];
    branch.tissue_kpa =
        RestingKpa(contact.tissue, input.heart_cycles, input.breath_level) + response.free_kpa;
    branch.opening_kpa = row.opening_kpa;
    branch.kpa_s_per_ml = row.entry_kpa_s_per_ml / contact.share + response.kpa_s_per_ml;
    if (row.space_compliance_ml_per_kpa > 0.0) {
      branch.tissue_kpa += (fluid.liquid_ml + fluid.air_ml) / row.space_compliance_ml_per_kpa;
      branch.kpa_s_per_ml += dt_s / row.space_compliance_ml_per_kpa;
    }
    double available_ml = 0.0;
    if (row.returns == Return::kInjected) {
      available_ml = std::min(state.available_ml[i],
                              std::max(0.0, fluid.liquid_ml) + std::max(0.0, fluid.air_ml));
    }
    if (row.returns == Return::kContent) available_ml = row.content_ml + fluid.liquid_ml;
    branch.least_ml_per_s = -std::max(0.0, available_ml) / dt_s;
  }
  return law;
}

bool FluidModel::PushesAir(const FluidState& state) const noexcept {
  const bool air_enters = state.hub == Hub::kOpen || state.liquid_ml <= kTraceMl;
  return air_enters ? state.lumen_liquid_ml <= kTraceMl
                    : state.lumen_liquid_ml < lumen_ml_ - kTraceMl;
}

LumenResistance FluidModel::ResistanceNow(const FluidState& state) const noexcept {
  const double wet = Within(state.lumen_liquid_ml / lumen_ml_, 0.0, 1.0);
  const auto mix = [wet](double liquid, double air) { return wet * liquid + (1.0 - wet) * air; };
  return {
      mix(liquid_resistance_.linear_kpa_s_per_ml, air_resistance_.linear_kpa_s_per_ml),
      mix(liquid_resistance_.quadratic_kpa_s2_per_ml2, air_resistance_.quadratic_kpa_s2_per_ml2)};
}

FluidOutput FluidModel::Step(FluidState& state, const FluidInput& raw,
                             double step_s) const noexcept {
  const double dt_s = Within(FiniteOr(step_s, kLeastStepS), kLeastStepS, kMostStepS);
  const FluidInput input = Usable(raw, state, table_.tissues.size());
  ChangeHub(state, input.hub);
  FollowTip(state, input);
  PlungerEquation equation;
  equation.law = LawAt(state, input, dt_s);
  equation.dt_s = dt_s;
  FluidOutput output;
  PlungerEquation::Root root;
  if (state.hub == Hub::kStylet) {
    root.bevel_kpa = equation.law.branch[0].tissue_kpa;
  } else {
    equation.lumen = ResistanceNow(state);
    if (PushesAir(state)) {
      equation.expansion = Within(
          (kAtmosphericKpa + state.syringe_kpa) / std::max(1.0, kAtmosphericKpa + state.bevel_kpa),
          1.0, 100.0);
    }
    if (state.hub == Hub::kSyringe) {
      equation.syringe = &syringe_;
      equation.liquid_ml = state.liquid_ml;
      equation.air_ml = state.air_ml;
      equation.start_mm = state.plunger_mm;
      equation.start_mm_per_s = state.plunger_mm_per_s;
      equation.stick_mm = state.friction.stick_mm;
      equation.stick_n_s_per_mm = StickDampingNSPerMm(syringe_);
      equation.yield_n = YieldN(syringe_, state.friction.slip_mm_per_s);
      SetDrive(input, equation);
    }
    root = equation.Solve(state.bevel_kpa, options_.max_iterations);
  }
  const PlungerEquation::Point& point = root.point;
  state.bevel_kpa = root.bevel_kpa;
  output.iterations = root.iterations;
  MoveFluid(state, point.flow, point.needle_ml_per_s * dt_s, point.syringe_kpa, dt_s, output);
  AdvanceTissues(state, point.flow, dt_s);
  if (state.hub == Hub::kSyringe) {
    const double travel_mm = point.plunger_mm - state.plunger_mm;
    state.plunger_mm_per_s = travel_mm / dt_s;
    state.plunger_mm = point.plunger_mm;
    state.friction.slip_mm_per_s = (travel_mm - point.stick_mm + state.friction.stick_mm) / dt_s;
    state.friction.stick_mm = point.stick_mm;
    state.syringe_kpa = point.syringe_kpa;
    output.barrel_n = point.resisting_n;
    output.reaction_n = input.drive == Drive::kForce
                            ? point.resisting_n
                            : equation.hand_n - equation.hand_n_per_mm * travel_mm -
                                  equation.hand_n_s_per_mm * state.plunger_mm_per_s;
  }
  output.plunger_mm = state.plunger_mm;
  output.flow_ml_per_s = point.needle_ml_per_s;
  output.syringe_kpa = state.syringe_kpa;
  output.bevel_kpa = state.bevel_kpa;
  const int main = input.bevel[1].share > input.bevel[0].share ? 1 : 0;
  output.resting_kpa = RestingKpa(input.bevel[static_cast<std::size_t>(main)].tissue,
                                  input.heart_cycles, input.breath_level);
  output.air_in_syringe_ml = AirVolumeMl(state.air_ml, state.syringe_kpa);
  const double wet_ml = state.liquid_ml + state.lumen_liquid_ml;
  output.drawn_share = wet_ml > kTraceMl ? Within(state.drawn_ml / wet_ml, 0.0, 1.0) : 0.0;
  return output;
}

}  // namespace acus::fluid
