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

/// Its integral: 0 below 0, t - 1/2 above 1.
double RampIntegral(double t) {
  if (t <= 0.0) return 0.0;
  if (t >= 1.0) return t - 0.5;
  return t * t * t * t * (2.5 + t * (t - 3.0));
}

constexpr double kWallLayerMm = 12.0;   // In which tissue is turned along the wall.
constexpr double kLargestStepMm = 3.0;  // Largest step of the integration.

// Lung above the domes, after matched points of two patients (DIR-Lab cases 2 and 4).
constexpr double kBandMm = 5.0;          // Above and below the way of the domes, that moves as one.
constexpr double kSoftStartMm = 20.0;    // Above the diaphragm, in which the fall begins.
constexpr double kFallPower = 1.25;      // Exponent of the share of the height to the top.
constexpr double kFrontPower = 1.6;      // Exponent of the place from back to front.
constexpr double kFrontLess = 0.45;      // Front of diaphragm and organs, less than their back.
constexpr double kFrontLessLung = 0.85;  // The same of lung...
constexpr double kFrontBlend = 0.3;      // ...from this share of its height on.
constexpr double kMiddleLess = 0.2;      // Mediastinum and middle of the diaphragm.
constexpr double kMiddleMm = 35.0;       // Its width (Gaussian).
constexpr double kBackwards = 0.4;       // AP motion half way up, relative to that of the domes.
constexpr double kStillInAp = 0.75;      // The place from back to front where it is 0.

// Abdomen: what the diaphragm displaces makes the wall bulge.
constexpr double kFallBelowMm = 330.0;  // From the domes to where nothing moves along the body.
constexpr double kFallEnds = 0.15;      // Share of this at either end in which the fall is soft.
constexpr double kForwardShare = 0.6;   // Forward share of the bulge; the rest is to the sides.
constexpr double kSpineClearMm = 20.0;  // From the midline, where the sides begin to move.
constexpr double kSideSoftMm = 20.0;
constexpr double kFrontSoftMm = 60.0;  // From the front of the spine.
// Chest: pump and bucket handle.
constexpr double kChestHeightMm = 150.0;  // Above the domes (Gaussian).
constexpr double kChestEndMm = 60.0;      // Below the domes.
constexpr double kBucketShare = 1.0;      // Sides of the chest, relative to its front.
constexpr double kChestHalfWidthMm = 130.0;

/// Share of the domes' motion along the body that is lost below the domes; its slope.
struct Fall {
  double lost = 0.0;
  double slope_per_mm = 0.0;
};

Fall FallBelow(double below_mm) {
  const double t = below_mm / kFallBelowMm;
  const double whole = 1.0 - kFallEnds;
  return {kFallEnds * (RampIntegral(t / kFallEnds) - RampIntegral((t - whole) / kFallEnds)) / whole,
          Ramp(t / kFallEnds) * (1.0 - Ramp((t - whole) / kFallEnds)) / (whole * kFallBelowMm)};
}

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
  // Full from the diaphragm down to where it goes; above, falling to the lungs' top; below, as the
  // abdominal wall bulges.
  const double base_mm = cavity_.diaphragm.AtMm(p.x(), p.y());
  const double above_mm = kSoftStartMm * RampIntegral((p.z() - base_mm - kBandMm) / kSoftStartMm);
  const double rise_mm = std::max(cavity_.top_z_mm - base_mm - kBandMm, 60.0) - 0.5 * kSoftStartMm;
  const double height = std::min(above_mm / rise_mm, 1.0);
  const double along =
      std::pow(1.0 - height, kFallPower) * (1.0 - FallBelow(BelowBandMm(p.z())).lost);
  // The back of lung and diaphragm goes farther than their front, the middle less than the sides.
  const double to_front = std::clamp(
      (cavity_.lung_back_mm - p.y()) / (cavity_.lung_back_mm - cavity_.lung_front_mm), 0.0, 1.0);
  const double front_less = kFrontLess + (kFrontLessLung - kFrontLess) * Ramp(height / kFrontBlend);
  const double from_middle = (p.x() - cavity_.middle_x_mm) / kMiddleMm;
  const double across = (1.0 - front_less * std::pow(to_front, kFrontPower)) *
                        (1.0 - kMiddleLess * std::exp(-0.5 * from_middle * from_middle));
  const double backwards = kBackwards * 4.0 * height * (1.0 - height) * (kStillInAp - to_front);
  const Vector3d free(0.0, down_mm * backwards - forward_mm * along, -down_mm * along * across);

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

double BreathingMotion::BelowBandMm(double z_mm) const noexcept {
  return cavity_.dome_z_mm - settings_.diaphragm_mm - 2.0 * kBandMm - z_mm;
}

BreathingMotion::Bulge BreathingMotion::BulgeAt(const Vector3d& p, double level) const noexcept {
  const double above_mm = p.z() - cavity_.dome_z_mm;
  const double up = above_mm / kChestHeightMm;
  const double chest_mm =
      level * settings_.chest_mm *
      (above_mm > 0.0 ? std::exp(-0.5 * up * up) : 1.0 - Ramp(-above_mm / kChestEndMm));
  // What the slowing flow loses in height the trunk gains in width: organs keep their volume.
  const double strain = level * settings_.diaphragm_mm * FallBelow(BelowBandMm(p.z())).slope_per_mm;

  const double depth_mm = cavity_.spine_front_mm - cavity_.skin_front_mm;
  const double before_spine_mm = cavity_.spine_front_mm - p.y();
  const double from_middle_mm = p.x() - cavity_.middle_x_mm;
  const double aside = (std::abs(from_middle_mm) - kSpineClearMm) / kSideSoftMm;
  const double aside_mm = kSideSoftMm * RampIntegral(aside);
  const double forward = kForwardShare * Ramp(before_spine_mm / kFrontSoftMm);

  const double front_strain = forward * strain;
  const double side_strain = (1.0 - forward) * strain + kBucketShare * chest_mm / kChestHalfWidthMm;
  const double share = std::clamp(before_spine_mm / depth_mm, 0.0, 1.0);
  const double chest_strain =
      chest_mm / depth_mm * 30.0 * share * share * (1.0 - share) * (1.0 - share);
  Bulge bulge;
  bulge.aside_mm = std::copysign(side_strain * aside_mm, from_middle_mm);
  bulge.forward_mm = chest_mm * Ramp(share) + kForwardShare * strain * kFrontSoftMm *
                                                  RampIntegral(before_spine_mm / kFrontSoftMm);
  bulge.growth = (1.0 + side_strain * Ramp(aside)) * (1.0 + front_strain + chest_strain);
  return bulge;
}

Vector3d BreathingMotion::WorldMm(const Vector3d& rest_mm, const breathing::Breath& breath,
                                  bool in_cavity) const noexcept {
  Vector3d x = rest_mm;
  if (in_cavity) {
    x = Flow(x, settings_.diaphragm_mm * breath.level, settings_.hysteresis_mm * Rate(breath));
  }
  const Bulge bulge = BulgeAt(x, breath.level);
  return x + Vector3d(bulge.aside_mm, -bulge.forward_mm, 0.0);
}

Vector3d BreathingMotion::BeforeChestMm(const Vector3d& world_mm,
                                        const breathing::Breath& breath) const noexcept {
  Vector3d before = world_mm;
  for (int n = 0; n < 60; ++n) {
    const Bulge bulge = BulgeAt(before, breath.level);
    const Vector3d next = world_mm - Vector3d(bulge.aside_mm, -bulge.forward_mm, 0.0);
    const double change = (next - before).squaredNorm();
    before = next;
    if (change < 1e-12) break;
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
