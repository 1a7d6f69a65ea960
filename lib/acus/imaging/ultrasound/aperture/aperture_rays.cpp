#include "acus/imaging/ultrasound/aperture/aperture_rays.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/imaging/acoustics/beam_width.h"

namespace acus::ultrasound {
namespace {

/// Elements hardly radiate beyond.
constexpr double kSteepestDeg = 45.0;

/// As AlongFaceMm, for lines that lean: `depth_mm` is the range along them.
double AlongSteeredFaceMm(const acoustics::Probe& probe, double tan_at_face, double depth_mm) {
  const double steer = probe.steer_rad;
  const double angle = std::atan(tan_at_face);
  if (probe.kind == acoustics::ProbeKind::kLinear) {
    return depth_mm * std::cos(steer) * (std::tan(steer + angle) - std::tan(steer));
  }
  // What the ray turns about the centre of the face, less what the line turns.
  const double radius_mm = probe.radius_mm;
  const double from_centre_mm = std::sqrt(radius_mm * radius_mm + depth_mm * depth_mm +
                                          2.0 * radius_mm * depth_mm * std::cos(steer));
  const auto turned = [&](double leaves) {
    return leaves - std::asin(std::clamp(radius_mm * std::sin(leaves) / from_centre_mm, -1.0, 1.0));
  };
  return radius_mm * (turned(steer + angle) - turned(steer));
}

/// Distance along the face, mm, between the element that a ray left and the line on which it is at
/// a depth.
double AlongFaceMm(const acoustics::Probe& probe, double tan_at_face, double depth_mm) {
  if (probe.steer_rad != 0.0) return AlongSteeredFaceMm(probe, tan_at_face, depth_mm);
  if (probe.kind == acoustics::ProbeKind::kLinear) return depth_mm * tan_at_face;
  const double radius_mm = probe.radius_mm;
  const double angle = std::atan(tan_at_face);
  return radius_mm * (angle - std::asin(radius_mm * std::sin(angle) / (radius_mm + depth_mm)));
}

/// The steepest ray that any place of the image needs.
double SteepestTan(const acoustics::Probe& probe, const acoustics::ScanGrid& grid) {
  const double limit =
      std::tan(kSteepestDeg * std::numbers::pi / 180.0 - std::abs(probe.steer_rad));
  double steepest = 0.0;
  for (int k = 1; k < grid.samples; k += std::max(1, grid.samples / 32)) {
    const double depth_mm = k * grid.step_mm;
    const double half_mm = 0.5 * acoustics::ReceiveApertureMm(probe, depth_mm);
    double low = 0.0;
    double high = limit;
    for (int n = 0; n < 30; ++n) {
      const double middle = 0.5 * (low + high);
      (AlongFaceMm(probe, middle, depth_mm) < half_mm ? low : high) = middle;
    }
    // Next to the face the aperture is a few elements, seen at any angle.
    if (half_mm < 0.5 * depth_mm) steepest = std::max(steepest, low);
  }
  return steepest;
}

}  // namespace

ApertureRays::ApertureRays(const acoustics::Probe& probe, const acoustics::ScanGrid& grid,
                           int directions)
    : rows_(grid.samples) {
  const bool single = probe.kind == acoustics::ProbeKind::kPhased || grid.lines() < 2 ||
                      (probe.kind == acoustics::ProbeKind::kCurvilinear && probe.radius_mm <= 0.0);
  const int half = single ? 0 : directions / 2;
  const double steepest = half > 0 ? SteepestTan(probe, grid) : 0.0;
  for (int d = -half; d <= half; ++d) {
    tan_at_face_.push_back(half > 0 ? steepest * d / half : 0.0);
  }
  const auto count = tan_at_face_.size() * static_cast<std::size_t>(rows_);
  shift_.assign(count, 0.0F);
  weight_.assign(count, 0.0F);
  last_row_.assign(tan_at_face_.size(), 0);
  // Lines are as far apart along the face at every depth, by angle or by length.
  const double line_mm = grid.lines() > 1 ? grid.LateralSpacingMm(0) : 1.0;
  for (int k = 0; k < rows_; ++k) {
    const double depth_mm = k * grid.step_mm;
    const double half_mm = 0.5 * acoustics::ReceiveApertureMm(probe, depth_mm);
    double sum = 0.0;
    std::vector<double> weights;
    for (int d = 0; d < this->directions(); ++d) {
      const double along_mm =
          half > 0 ? AlongFaceMm(probe, tan_at_face_[static_cast<std::size_t>(d)], depth_mm) : 0.0;
      const double share = std::abs(along_mm) / half_mm;
      const bool middle = d == half;
      weights.push_back(middle        ? 1.0
                        : share < 1.0 ? std::cos(0.5 * std::numbers::pi * share)
                                      : 0.0);
      sum += weights.back();
      shift_[At(d, k)] = static_cast<float>(along_mm / line_mm);
    }
    for (int d = 0; d < this->directions(); ++d) {
      const double weight =
          k == 0 ? (d == half ? 1.0 : 0.0) : weights[static_cast<std::size_t>(d)] / sum;
      weight_[At(d, k)] = static_cast<float>(weight);
      if (weight > 0.0) {
        last_row_[static_cast<std::size_t>(d)] = k;
        most_lines_ = std::max(most_lines_, std::abs(shift_[At(d, k)]));
      }
    }
  }
}

}  // namespace acus::ultrasound
