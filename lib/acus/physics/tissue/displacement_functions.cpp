#include "acus/physics/tissue/displacement_functions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "acus/base/core/error.h"

namespace acus::tissue {
namespace {

constexpr double kPrintedLengthMm = 1.0;
constexpr double kProbeDepthMm = 1.0;       // The skin's modulus is requested so far inside it.
constexpr double kShallowestShaftMm = 1.0;  // Friction is spread over at least this length.
constexpr double kLongestBlend = 4.0;       // Of R_max.
constexpr double kFarthestMm = 1e5;

bool IsUsable(const NeedleLoad& needle) {
  const double length = needle.axis_in_ct.norm();
  return needle.in_contact && length > 1e-9 && length < 1e9 && needle.entry_in_ct_mm.allFinite() &&
         needle.tip_in_ct_mm.allFinite() &&
         needle.entry_in_ct_mm.cwiseAbs().maxCoeff() <= kFarthestMm &&
         needle.tip_in_ct_mm.cwiseAbs().maxCoeff() <= kFarthestMm &&
         std::isfinite(needle.pre_puncture_n) && std::isfinite(needle.cutting_n) &&
         std::isfinite(needle.friction_n);
}

}  // namespace

double Fade(double t) noexcept {
  if (!(t > 0.0)) return 1.0;
  return t < 1.0 ? (1.0 - t) * (1.0 - t) * (1.0 + 2.0 * t) : 0.0;
}

double ShaftFade(double t) noexcept {
  if (!(t > 0.0)) return 5.0;
  return t < 1.0 ? (1.0 - t) * (1.0 - t) * (5.0 - 2.0 * t) : 0.0;
}

DisplacementFunctionSettings DisplacementFunctionSettings::AsPrinted() {
  DisplacementFunctionSettings settings;
  settings.tip_length_mm = kPrintedLengthMm;
  settings.transition_mm = 0.0;
  settings.modulus_blend_mm = 0.0;
  settings.shaft_factor_at_axis = false;
  settings.largest_share = std::numeric_limits<double>::infinity();
  return settings;
}

DisplacementFunctions::DisplacementFunctions(const DisplacementFunctionSettings& settings,
                                             ModulusAt modulus)
    : settings_(settings), modulus_(std::move(modulus)) {
  ACUS_REQUIRE(settings.influence_radius_mm > 0.0 && std::isfinite(settings.influence_radius_mm),
               "influence_radius_mm is ", settings.influence_radius_mm, "; allowed: above 0");
  ACUS_REQUIRE(settings.tip_length_mm >= 0.0, "tip_length_mm is ", settings.tip_length_mm,
               "; allowed: above 0, or 0 for 4 pi / 5 of influence_radius_mm");
  if (settings_.tip_length_mm == 0.0) {
    settings_.tip_length_mm = 0.8 * std::numbers::pi * settings.influence_radius_mm;
  }
  ACUS_REQUIRE(settings.largest_share > 0.0, "largest_share is ", settings.largest_share,
               "; allowed: above 0, at most 0.66 for a field that does not fold");
  ACUS_REQUIRE(settings.transition_mm >= 0.0 && settings.modulus_blend_mm >= 0.0,
               "transition_mm is ", settings.transition_mm, " and modulus_blend_mm ",
               settings.modulus_blend_mm, "; allowed: at least 0");
  ACUS_ASSERT(modulus_ != nullptr);
}

DisplacementFunctions::Prepared DisplacementFunctions::Prepare(const TissueLoad& load) const {
  const NeedleLoad& needle = load.needle;
  Prepared out;
  if (!IsUsable(needle)) return out;
  out.axis_in_ct = needle.axis_in_ct.normalized();
  out.entry_in_ct_mm = needle.entry_in_ct_mm;
  out.depth_mm = std::max(0.0, (needle.tip_in_ct_mm - needle.entry_in_ct_mm).dot(out.axis_in_ct));
  out.pierced = needle.pierced;
  const double modulus_mpa = modulus_(out.entry_in_ct_mm + kProbeDepthMm * out.axis_in_ct);
  if (!(modulus_mpa > 0.0)) return out;  // No tissue where the needle is said to be in contact.
  out.entry_compliance_per_mpa = 1.0 / modulus_mpa;
  out.active = true;
  out.blend_mm = settings_.modulus_blend_mm;
  double shaft_now_mm = 0.0;
  if (out.pierced) {
    out.shaft_mpa_mm = needle.friction_n / std::max(out.depth_mm, kShallowestShaftMm);
    out.tip_mpa_mm = (needle.cutting_n + needle.pre_puncture_n) / settings_.tip_length_mm;
    shaft_now_mm = out.shaft_mpa_mm * out.entry_compliance_per_mpa;
  } else {
    shaft_now_mm = out.shaft_mm = out.depth_mm;
    // "Exactly equal to the displacement of this same tip": the length is the one that gives this.
    const double compliance = ComplianceAt(out, needle.tip_in_ct_mm);
    out.tip_mpa_mm = needle.pre_puncture_n / settings_.tip_length_mm;
    if (settings_.shaft_factor_at_axis) {
      out.tip_mpa_mm = compliance > 0.0 ? out.depth_mm / compliance : 0.0;  // 0: on bone.
    }
  }
  const double limit_mm = settings_.largest_share * settings_.influence_radius_mm;
  const double shaft_mm = std::clamp(shaft_now_mm, -limit_mm, limit_mm);
  const double tip_compliance = ComplianceAt(out, needle.tip_in_ct_mm);
  const double tip_mm =
      std::min(out.tip_mpa_mm * std::max(out.entry_compliance_per_mpa, tip_compliance), limit_mm);
  if (settings_.transition_mm > 0.0) {
    // Twice the difference holds the slope along the needle to 0.4; steeper than 1, tissue folds.
    const double wanted_mm = std::max({settings_.transition_mm, 2.0 * std::abs(shaft_mm - tip_mm),
                                       0.7 * std::max(std::abs(shaft_mm), tip_mm)});
    out.half_transition_mm = std::min(wanted_mm, settings_.influence_radius_mm);
  }
  if (out.pierced && settings_.modulus_blend_mm > 0.0) {
    const double most_per_mpa = std::max(out.entry_compliance_per_mpa, tip_compliance);
    const double largest_mm =
        most_per_mpa * std::max(std::abs(out.shaft_mpa_mm), std::abs(out.tip_mpa_mm));
    out.blend_mm = std::clamp(
        2.0 * largest_mm, settings_.modulus_blend_mm,
        std::max(settings_.modulus_blend_mm, kLongestBlend * settings_.influence_radius_mm));
  }
  return out;
}

double DisplacementFunctions::CompliancePoint(const Prepared& prepared,
                                              const Eigen::Vector3d& rest_mm) const noexcept {
  const double modulus_mpa = modulus_(rest_mm);
  // Air moves with the skin, so that the skin's own displacement has no step.
  return modulus_mpa > 0.0 ? 1.0 / modulus_mpa : prepared.entry_compliance_per_mpa;
}

double DisplacementFunctions::ComplianceAt(const Prepared& prepared,
                                           const Eigen::Vector3d& rest_mm) const noexcept {
  const double spacing_mm = prepared.blend_mm;
  if (spacing_mm == 0.0) return CompliancePoint(prepared, rest_mm);
  const Eigen::Vector3d cell = rest_mm / spacing_mm;
  const Eigen::Vector3d low = cell.array().floor();
  const Eigen::Vector3d part = cell - low;
  double sum = 0.0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d step(corner & 1, (corner >> 1) & 1, corner >> 2);
    const Eigen::Vector3d weight =
        step.cwiseProduct(part) +
        (Eigen::Vector3d::Ones() - step).cwiseProduct(Eigen::Vector3d::Ones() - part);
    const double w = weight.prod();
    if (w > 0.0) sum += w * CompliancePoint(prepared, spacing_mm * (low + step));
  }
  return sum;
}

Eigen::Vector3d DisplacementFunctions::DisplacementMm(
    const Prepared& prepared, const Eigen::Vector3d& rest_in_ct_mm) const noexcept {
  if (!prepared.active) return Eigen::Vector3d::Zero();
  const double radius_mm = settings_.influence_radius_mm;
  const Eigen::Vector3d from_entry = rest_in_ct_mm - prepared.entry_in_ct_mm;
  const double z_mm = from_entry.dot(prepared.axis_in_ct);
  const double aside_mm = (from_entry - z_mm * prepared.axis_in_ct).norm();
  if (!(aside_mm < radius_mm) || z_mm < -radius_mm || z_mm > prepared.depth_mm + radius_mm) {
    return Eigen::Vector3d::Zero();
  }
  const double beyond_mm = z_mm - prepared.depth_mm;
  const double half_mm = prepared.half_transition_mm;
  const double shaft_share =
      half_mm > 0.0 ? Fade(0.5 + 0.5 * beyond_mm / half_mm) : (beyond_mm < 0.0 ? 1.0 : 0.0);
  const bool needs_compliance = prepared.pierced || shaft_share < 1.0;
  const double compliance = needs_compliance ? ComplianceAt(prepared, rest_in_ct_mm) : 0.0;
  const double limit_mm = settings_.largest_share * radius_mm;
  double along_mm = 0.0;
  if (shaft_share > 0.0) {
    // Cylindrical along the shaft; above the skin the same profile closes it like a ball.
    const double r_mm = std::hypot(aside_mm, std::min(z_mm, 0.0));
    const double peak = settings_.shaft_factor_at_axis ? 0.2 : 1.0;
    const double size_mm = prepared.shaft_mm + prepared.shaft_mpa_mm * compliance;
    along_mm +=
        shaft_share * peak * ShaftFade(r_mm / radius_mm) * std::clamp(size_mm, -limit_mm, limit_mm);
  }
  if (shaft_share < 1.0) {
    double size_mm = prepared.tip_mpa_mm * compliance;
    // What the tip presses in moves at most as far as the tip.
    if (!prepared.pierced && settings_.shaft_factor_at_axis) {
      size_mm = std::min(size_mm, prepared.depth_mm);
    }
    along_mm += (1.0 - shaft_share) * Fade(std::hypot(aside_mm, beyond_mm) / radius_mm) *
                std::min(size_mm, limit_mm);
  }
  return along_mm * prepared.axis_in_ct;
}

}  // namespace acus::tissue
