#include "acus/physics/needle/rod.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/core/error.h"
#include "acus/physics/needle/rod_sweeps.h"

namespace acus::needle {
namespace {

using Eigen::Vector3d;

constexpr int kHalvings = 12;
/// Beyond this movement of the hub in one call other starting shapes are tried too.
constexpr double kJumpMm = 5.0;
constexpr double kJumpRad = 0.1;
/// Rounding of the energy: a step that changes it by less is not held to lower it.
constexpr double kEnergyRounding = 1e-13;

bool IsUsable(const RodBase& base) noexcept {
  if (!IsNear(base.position_mm) || !base.orientation.coeffs().allFinite()) return false;
  const double norm2 = base.orientation.squaredNorm();
  if (!(norm2 > 1e-12 && norm2 < 1e12)) return false;
  if (!base.sprung) return true;
  return base.stiffness_n_per_mm > 0.0 && base.stiffness_n_mm_per_rad > 0.0 &&
         base.stiffness_n_per_mm <= kStiffest && base.stiffness_n_mm_per_rad <= kStiffest;
}

/// Rotation vector of the shorter turn, rad.
Vector3d RotationVector(const Eigen::Quaterniond& q) noexcept {
  const double sine = q.vec().norm();
  if (sine < 1e-9) return std::copysign(2.0, q.w()) * q.vec();
  const double angle = 2.0 * std::atan2(sine, std::abs(q.w()));
  return (std::copysign(angle, q.w()) / sine) * q.vec();
}

/// Springs that hold the hub: energy, gradient and stiffness by its position and rotation.
struct BaseSprings {
  RodBase base;

  Vector3d OffMm(const RodStart& hub) const noexcept { return hub.position_mm - base.position_mm; }
  Vector3d TurnRad(const RodStart& hub) const noexcept {
    return RotationVector(hub.orientation * base.orientation.conjugate());
  }
  double Energy(const RodStart& hub) const noexcept {
    if (!base.sprung) return 0.0;
    return 0.5 * (base.stiffness_n_per_mm * OffMm(hub).squaredNorm() +
                  base.stiffness_n_mm_per_rad * TurnRad(hub).squaredNorm());
  }
  BaseGradient Gradient(const RodStart& hub) const noexcept {
    return {base.stiffness_n_per_mm * OffMm(hub), base.stiffness_n_mm_per_rad * TurnRad(hub)};
  }
};

RodStart HubOf(const RodState& state) noexcept {
  return {state.point[0].position_mm, state.point[0].orientation};
}

/// One call of Solve.
class Solver {
 public:
  Solver(const RodModel& model, const RodBase& base, RodState& state) noexcept
      : model_(model), springs_{base}, state_(state) {
    springs_.base.orientation.normalize();
    target_ = {base.position_mm, springs_.base.orientation};
  }

  RodResult Run() noexcept;

 private:
  void TakeTrial(double energy) noexcept;
  void Start() noexcept;
  void StartAfterJump() noexcept;
  double Residual() noexcept;
  double Predict() noexcept;
  bool Step() noexcept;
  double Try(double fraction) noexcept;
  bool FindDirection(bool curved) noexcept;
  bool Shorten(double fraction) noexcept;
  RodStart MovedHub(double fraction) const noexcept;
  Eigen::Matrix<double, 6, 1> HubStep(BaseModel& base) noexcept;

  const RodModel& model_;
  BaseSprings springs_;
  RodState& state_;
  RodStart target_;
  Eigen::Matrix<double, 6, 1> hub_step_ = Eigen::Matrix<double, 6, 1>::Zero();
  double energy_ = 0.0;
  int iterations_ = 0;
};

void Solver::TakeTrial(double energy) noexcept {
  state_.point.swap(state_.trial);
  state_.action.swap(state_.trial_action);
  energy_ = energy;
}

/// From a new state, from where the hub was, or at a jump from the best of three shapes.
void Solver::Start() noexcept {
  if (!state_.started) {
    for (RodPoint& point : state_.point) {
      point.curvature_per_mm = model_.properties().rest_curvature_per_mm;
    }
    TakeTrial(LayOut(model_, target_, state_.point, state_));
    energy_ += springs_.Energy(HubOf(state_));
    state_.started = true;
    return;
  }
  energy_ = Place(model_, state_) + springs_.Energy(HubOf(state_));
  // A clamped hub is where its target was; a sprung one may be far from it for good.
  const RodStart before =
      springs_.base.sprung ? RodStart{state_.target_mm, state_.target_orientation} : HubOf(state_);
  const double moved_mm = springs_.OffMm(before).norm();
  const double turned_rad = springs_.TurnRad(before).norm();
  if (moved_mm > kJumpMm || turned_rad > kJumpRad) {
    StartAfterJump();
  } else if (!springs_.base.sprung && (moved_mm > 0.0 || turned_rad > 0.0)) {
    TakeTrial(Predict());
  }
}

/// Lays out the shape with the hub at its target by the Newton matrix of the shape before: what
/// tissue holds stays about where it is. Into the trial; returns its energy.
double Solver::Predict() noexcept {
  ++iterations_;
  Balance(model_, state_);
  if (TipToBase(model_, true, state_).repaired) TipToBase(model_, false, state_);
  return LayOutStep(model_, target_, 1.0, state_);
}

/// The best of the shape moved along as it is, of the predicted one, and of the needle without
/// load.
void Solver::StartAfterJump() noexcept {
  const double infinite = std::numeric_limits<double>::infinity();
  const auto usable = [&](double energy) { return std::isfinite(energy) ? energy : infinite; };
  const double rigid = usable(LayOut(model_, target_, state_.point, state_));
  const double predicted = usable(Predict());
  for (RodPoint& point : state_.trial) {
    point.curvature_per_mm = model_.properties().rest_curvature_per_mm;
  }
  const double straight = usable(LayOut(model_, target_, state_.trial, state_));
  // A sprung hub may also stay and follow by itself.
  const double old = springs_.base.sprung ? usable(energy_) : infinite;
  const double best = std::min({old, predicted, rigid, straight});
  if (springs_.base.sprung && best == old) return;
  if (best == predicted && best < infinite) {
    TakeTrial(LayOutStep(model_, target_, 1.0, state_));
  } else if (best == rigid) {
    TakeTrial(LayOut(model_, target_, state_.point, state_));
  } else {
    ++state_.num_restarts;
    TakeTrial(LayOut(model_, target_, state_.trial, state_));
  }
}

double Solver::Residual() noexcept {
  double residual = Balance(model_, state_);
  if (springs_.base.sprung) {
    const BaseGradient rod = GradientAtBase(state_);
    const BaseGradient spring = springs_.Gradient(HubOf(state_));
    const double length_mm = model_.properties().length_mm;
    residual = std::max({residual, (rod.moment_n_mm + spring.moment_n_mm).norm(),
                         length_mm * (rod.force_n + spring.force_n).norm()});
  }
  return residual;
}

/// Newton step of a sprung hub; 0 for a clamped one.
Eigen::Matrix<double, 6, 1> Solver::HubStep(BaseModel& base) noexcept {
  if (!springs_.base.sprung) return Eigen::Matrix<double, 6, 1>::Zero();
  const BaseGradient rod = GradientAtBase(state_);
  const BaseGradient spring = springs_.Gradient(HubOf(state_));
  base.gradient.head<3>() += rod.force_n + spring.force_n;
  base.gradient.tail<3>() += rod.moment_n_mm + spring.moment_n_mm;
  base.hessian.diagonal().head<3>().array() += springs_.base.stiffness_n_per_mm;
  base.hessian.diagonal().tail<3>().array() += springs_.base.stiffness_n_mm_per_rad;
  Eigen::LLT<Eigen::Matrix<double, 6, 6>> factor(base.hessian);
  if (factor.info() != Eigen::Success) {
    base.repaired = true;
    // The springs alone: a descent direction whatever the rod's own matrix is.
    Eigen::Matrix<double, 6, 1> step = -base.gradient;
    step.head<3>() /= springs_.base.stiffness_n_per_mm;
    step.tail<3>() /= springs_.base.stiffness_n_mm_per_rad;
    return step;
  }
  return -factor.solve(base.gradient);
}

RodStart Solver::MovedHub(double fraction) const noexcept {
  if (!springs_.base.sprung) return target_;
  RodStart hub = HubOf(state_);
  hub.position_mm += fraction * hub_step_.head<3>();
  hub.orientation = TurnQuaternion(fraction * hub_step_.tail<3>()) * hub.orientation;
  hub.orientation.normalize();
  return hub;
}

/// The energy of a step of this length along the last direction; the shape is in the trial.
double Solver::Try(double fraction) noexcept {
  const RodStart hub = MovedHub(fraction);
  const double energy = LayOutStep(model_, hub, fraction, state_) + springs_.Energy(hub);
  return std::isfinite(energy) ? energy : std::numeric_limits<double>::infinity();
}

/// Finds the direction of Newton's (curved) or the Gauss-Newton step. False if it was repaired.
bool Solver::FindDirection(bool curved) noexcept {
  BaseModel base = TipToBase(model_, curved, state_);
  hub_step_ = HubStep(base);
  return !base.repaired;
}

/// Takes a shorter and shorter step along the last direction, until one lowers the energy.
bool Solver::Shorten(double fraction) noexcept {
  for (int halving = 0; halving < kHalvings; ++halving, fraction *= 0.5) {
    const double energy = Try(fraction);
    if (energy < energy_) {
      TakeTrial(energy);
      return true;
    }
  }
  return false;
}

/// One step that does not raise the energy. False if there is none.
bool Solver::Step() noexcept {
  const double slack = kEnergyRounding * (1.0 + std::abs(energy_));
  if (FindDirection(true)) {
    const double energy = Try(1.0);
    if (energy <= energy_ + slack) {
      TakeTrial(energy);
      return true;
    }
    if (Shorten(0.5)) return true;
    FindDirection(false);
    return Shorten(1.0);
  }
  // Far from rest, where Gauss-Newton is better, or buckling, where it hardly moves.
  ++state_.num_repaired;
  double fraction = 1.0;
  double newton = Try(1.0);
  for (const double shorter : {0.5, 0.25, 0.125}) {
    const double energy = Try(shorter);
    if (energy >= newton) continue;
    newton = energy;
    fraction = shorter;
  }
  FindDirection(false);
  const double gauss = Try(1.0);
  if (gauss < energy_ && gauss <= newton) {
    TakeTrial(gauss);
    return true;
  }
  FindDirection(true);
  if (Shorten(fraction)) return true;
  FindDirection(false);
  return Shorten(1.0);
}

RodResult Solver::Run() noexcept {
  RodResult result;
  Start();
  state_.target_mm = target_.position_mm;
  state_.target_orientation = target_.orientation;
  result.status = RodStatus::kIterationLimit;
  for (;; ++iterations_) {
    result.moment_residual_n_mm = Residual();
    if (result.moment_residual_n_mm <= model_.moment_tolerance_n_mm()) {
      result.status = RodStatus::kConverged;
      break;
    }
    if (iterations_ >= model_.options().max_iterations) break;
    if (!Step()) {
      result.status = RodStatus::kStalled;
      break;
    }
  }
  result.iterations = iterations_;
  const BaseGradient base = GradientAtBase(state_);
  result.energy_n_mm = energy_;
  result.base_force_n = -base.force_n;
  result.base_torque_n_mm = -base.moment_n_mm;
  if (!result.converged()) ++state_.num_not_converged;
  return result;
}

}  // namespace

std::string_view NameOf(RodStatus status) noexcept {
  switch (status) {
    case RodStatus::kConverged:
      return "converged";
    case RodStatus::kIterationLimit:
      return "iteration limit";
    case RodStatus::kStalled:
      return "stalled";
    case RodStatus::kRejected:
      return "rejected";
  }
  return "";
}

RodModel::RodModel(const RodProperties& properties, const RodOptions& options)
    : properties_(properties), options_(options) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  ACUS_REQUIRE(positive(properties.length_mm), "needle: length_mm is ", properties.length_mm,
               "; it must be above 0");
  ACUS_REQUIRE(positive(properties.bending_n_mm2), "needle: bending stiffness is ",
               properties.bending_n_mm2, " N mm2; it must be above 0");
  ACUS_REQUIRE(positive(properties.twist_n_mm2), "needle: twist stiffness is ",
               properties.twist_n_mm2, " N mm2; it must be above 0");
  ACUS_REQUIRE(properties.rest_curvature_per_mm.allFinite(),
               "needle: rest curvature is not a number");
  ACUS_REQUIRE(options.num_nodes >= 2 && options.num_nodes <= 100000, "needle: num_nodes is ",
               options.num_nodes, "; it must be from 2 to 100000");
  ACUS_REQUIRE(positive(options.tolerance_mm), "needle: tolerance_mm is ", options.tolerance_mm,
               "; it must be above 0");
  ACUS_REQUIRE(options.max_iterations >= 1, "needle: max_iterations is ", options.max_iterations,
               "; it must be 1 or more");
  ACUS_REQUIRE(options.max_contacts >= 0, "needle: max_contacts is ", options.max_contacts,
               "; it must be 0 (chosen by itself) or more");
  if (options_.max_contacts == 0) options_.max_contacts = 2 * options.num_nodes + 8;
  spacing_mm_ = properties.length_mm / num_elements();
  moment_tolerance_n_mm_ = 2.0 * properties.bending_n_mm2 * options.tolerance_mm /
                           (properties.length_mm * properties.length_mm);
}

RodState RodModel::NewState() const {
  RodState state;
  state.point.resize(options_.num_nodes);
  state.trial.resize(options_.num_nodes);
  state.sweep.resize(num_elements());
  state.action.resize(options_.max_contacts);
  state.trial_action.resize(options_.max_contacts);
  return state;
}

RodResult RodModel::Solve(RodState& state, const RodInput& input) const noexcept {
  if (!IsUsable(input.base) || !TakeActions(*this, input, state)) {
    ++state.num_rejected;
    RodResult rejected = state.last;
    rejected.status = RodStatus::kRejected;
    rejected.iterations = 0;
    return rejected;
  }
  state.last = Solver(*this, input.base, state).Run();
  return state.last;
}

Eigen::Vector3d RodModel::PositionMm(const RodState& state, double arc_mm) const noexcept {
  const int i = std::clamp(static_cast<int>(arc_mm / spacing_mm_), 0, num_elements() - 1);
  const RodPoint& point = state.point[i];
  const double part_mm = std::clamp(arc_mm - i * spacing_mm_, 0.0, spacing_mm_);
  const ArcTerms arc = ArcTermsOf(part_mm, point.arc.turn_rad / spacing_mm_);
  return point.position_mm + ArcChord(arc, point.tangent);
}

Eigen::Vector3d RodModel::Tangent(const RodState& state, double arc_mm) const noexcept {
  const int i = std::clamp(static_cast<int>(arc_mm / spacing_mm_), 0, num_elements() - 1);
  const RodPoint& point = state.point[i];
  const double part_mm = std::clamp(arc_mm - i * spacing_mm_, 0.0, spacing_mm_);
  return TurnQuaternion(part_mm / spacing_mm_ * point.arc.turn_rad) * point.tangent;
}

}  // namespace acus::needle
