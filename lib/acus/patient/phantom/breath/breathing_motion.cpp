#include "acus/patient/phantom/breath/breathing_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace acus::phantom {
namespace {

using Eigen::Vector3d;

/// 0 below 0, 1 above 1, smooth between.
double Ramp(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * t * (10.0 + t * (6.0 * t - 15.0));
}

void RequireIn(const char* name, double value, double low, double high) {
  ACUS_REQUIRE(value >= low && value <= high, "breathing motion: ", name, " is ", value,
               "; it must be in [", low, ", ", high, "]");
}

constexpr double kFallBelowMm =
    240.0;                             // From the domes down to where nothing moves along the body.
constexpr double kWallLayerMm = 12.0;  // In which tissue is turned along the wall.
constexpr double kLargestStepMm = 3.0;  // Of the integration.

}  // namespace

BreathingMotion::BreathingMotion(Cavity cavity, const BreathingSettings& settings)
    : cavity_(std::move(cavity)), settings_(settings) {
  RequireIn("diaphragm_mm", settings.diaphragm_mm, 0.0, 80.0);
  RequireIn("chest_mm", settings.chest_mm, 0.0, 30.0);
  RequireIn("hysteresis_mm", settings.hysteresis_mm, 0.0, 20.0);
  RequireIn("period_s", settings.period_s, 0.5, 60.0);
}

double BreathingMotion::Rate(const breathing::Breath& breath) const noexcept {
  // +-1 at the steepest of a sinusoidal breath.
  return breath.level_per_s * settings_.period_s / std::numbers::pi;
}

Vector3d BreathingMotion::Velocity(const Vector3d& p, double down_mm,
                                   double forward_mm) const noexcept {
  // Full in a band around the domes that holds their way; above, falling to the lungs' top; below,
  // over 240 mm.
  const double half_band = 0.5 * settings_.diaphragm_mm + 5.0;
  const double above = p.z() - (cavity_.dome_z_mm + 5.0);
  const double below = cavity_.dome_z_mm - 2.0 * half_band - p.z();
  const double rise = std::max(cavity_.top_z_mm - cavity_.dome_z_mm - 5.0, 40.0);
  const double along = (1.0 - Ramp(above / rise)) * (1.0 - Ramp(below / kFallBelowMm));
  // The back of the diaphragm goes farther than its front, the middle less than the sides.
  const double depth = cavity_.spine_front_mm - cavity_.skin_front_mm;
  const double to_front = (cavity_.spine_front_mm - p.y()) / depth;
  const double from_middle = (p.x() - cavity_.middle_x_mm) / 45.0;
  const double across =
      (1.0 - 0.3 * Ramp(to_front)) * (1.0 - 0.35 * std::exp(-0.5 * from_middle * from_middle));
  const Vector3d free(0.0, -forward_mm * along, -down_mm * along * across);

  const SmoothLevel::Sample wall = cavity_.wall.At(p);
  const double layer = wall.level_mm / kWallLayerMm;
  const double length2 = wall.gradient.squaredNorm();
  if (length2 < 1e-6) return free;
  return free - std::exp(-layer * layer) / length2 * free.dot(wall.gradient) * wall.gradient;
}

Vector3d BreathingMotion::Flow(const Vector3d& p, double down_mm,
                               double forward_mm) const noexcept {
  const double way_mm = std::hypot(down_mm, forward_mm);
  if (way_mm == 0.0) return p;
  const int steps = std::clamp(static_cast<int>(std::ceil(way_mm / kLargestStepMm)), 2, 64);
  const double h = 1.0 / steps;
  Vector3d x = p;
  for (int n = 0; n < steps; ++n) {
    const Vector3d k1 = Velocity(x, down_mm, forward_mm);
    const Vector3d k2 = Velocity(x + 0.5 * h * k1, down_mm, forward_mm);
    const Vector3d k3 = Velocity(x + 0.5 * h * k2, down_mm, forward_mm);
    const Vector3d k4 = Velocity(x + h * k3, down_mm, forward_mm);
    x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  }
  return x;
}

double BreathingMotion::ChestForwardMm(const Vector3d& p, double level) const noexcept {
  const double depth = cavity_.spine_front_mm - cavity_.skin_front_mm;
  const double share = Ramp((cavity_.spine_front_mm - p.y()) / depth);
  const double along = (p.z() - cavity_.dome_z_mm) / 150.0;
  return level * settings_.chest_mm * share * std::exp(-0.5 * along * along);
}

Vector3d BreathingMotion::WorldMm(const Vector3d& rest_mm, const breathing::Breath& breath,
                                  bool in_cavity) const noexcept {
  Vector3d x = rest_mm;
  if (in_cavity) {
    x = Flow(x, settings_.diaphragm_mm * breath.level, settings_.hysteresis_mm * Rate(breath));
  }
  x.y() -= ChestForwardMm(x, breath.level);
  return x;
}

Vector3d BreathingMotion::BeforeChestMm(const Vector3d& world_mm,
                                        const breathing::Breath& breath) const noexcept {
  Vector3d before = world_mm;
  for (int n = 0; n < 40; ++n) {
    const double y = world_mm.y() + ChestForwardMm(before, breath.level);
    const double change = std::abs(y - before.y());
    before.y() = y;
    if (change < 1e-6) break;
  }
  return before;
}

Vector3d BreathingMotion::BeforeSlidingMm(const Vector3d& slid_mm,
                                          const breathing::Breath& breath) const noexcept {
  return Flow(slid_mm, -settings_.diaphragm_mm * breath.level,
              -settings_.hysteresis_mm * Rate(breath));
}

Vector3d BreathingMotion::RestMm(const Vector3d& world_mm, const breathing::Breath& breath) const {
  const Vector3d slid = BeforeChestMm(world_mm, breath);
  // The flow keeps to its side of the wall: who is in now was in before.
  if (!InCavity(slid)) return slid;
  Vector3d rest = BeforeSlidingMm(slid, breath);
  // The backward flow is the inverse up to the error of its steps; what remains is taken off.
  for (int n = 0; n < 4; ++n) {
    const Vector3d error = WorldMm(rest, breath, true) - world_mm;
    if (error.norm() < 1e-3) break;
    rest -= error;
  }
  return rest;
}

}  // namespace acus::phantom
