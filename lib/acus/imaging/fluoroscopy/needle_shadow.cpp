#include "acus/imaging/fluoroscopy/needle_shadow.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "acus/base/core/error.h"

namespace acus::fluoroscopy {
namespace {

constexpr int kRaysAcross = 4;

/// Distance of a point from a straight piece, all in pixels.
double DistancePx(const Eigen::Vector2d& p, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  return (p - (a + t * along)).norm();
}

/// The needle's axis, tip first.
std::span<const Eigen::Vector3d> AxisOf(const image::NeedleInImage& needle,
                                        std::array<Eigen::Vector3d, 2>& straight) {
  if (needle.shape.num_points >= 2) {
    return {needle.shape.point_mm.data(), static_cast<std::size_t>(needle.shape.num_points)};
  }
  straight = {needle.tip_in_ct_mm, needle.tip_in_ct_mm - needle.length_mm * needle.axis_in_ct};
  return straight;
}

}  // namespace

double CylinderChordMm(const Eigen::Vector3d& origin_mm, const Eigen::Vector3d& direction,
                       const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm,
                       double radius_mm) {
  const Eigen::Vector3d along = to_mm - from_mm;
  const double length_mm = along.norm();
  if (!(length_mm > 0.0)) return 0.0;
  const Eigen::Vector3d axis = along / length_mm;
  const Eigen::Vector3d offset = origin_mm - from_mm;
  const double offset_along = offset.dot(axis);
  const double direction_along = direction.dot(axis);
  double begin = 0.0;
  double end = 1e30;
  // Between the flat ends.
  if (std::abs(direction_along) > 1e-12) {
    const double t0 = -offset_along / direction_along;
    const double t1 = (length_mm - offset_along) / direction_along;
    begin = std::max(begin, std::min(t0, t1));
    end = std::min(end, std::max(t0, t1));
  } else if (offset_along < 0.0 || offset_along > length_mm) {
    return 0.0;
  }
  // Within the radius: |u + t v| < r across the axis.
  const Eigen::Vector3d u = offset - offset_along * axis;
  const Eigen::Vector3d v = direction - direction_along * axis;
  const double vv = v.squaredNorm();
  const double uu = u.squaredNorm() - radius_mm * radius_mm;
  if (vv > 1e-24) {
    const double uv = u.dot(v);
    const double root = uv * uv - vv * uu;
    if (root <= 0.0) return 0.0;
    begin = std::max(begin, (-uv - std::sqrt(root)) / vv);
    end = std::min(end, (-uv + std::sqrt(root)) / vv);
  } else if (uu >= 0.0) {
    return 0.0;
  }
  return std::max(0.0, end - begin);
}

void NeedleShadow::Add(const image::NeedleInImage& needle, const CArm& c_arm,
                       const CArmGeometry& geometry, float* sums, int stride) {
  std::array<Eigen::Vector3d, 2> straight;
  const auto axis = AxisOf(needle, straight);
  ACUS_REQUIRE(std::ranges::all_of(axis, [](const auto& p) { return p.allFinite(); }) &&
                   needle.radius_mm >= 0.0 && std::isfinite(needle.radius_mm),
               "needle in the fluoroscopy: its pose is not finite or its radius (",
               needle.radius_mm, " mm) is below 0");
  seen_.resize(static_cast<std::size_t>(c_arm.width_px) * c_arm.height_px, 0);
  pixels_.clear();
  for (std::size_t n = 0; n + 1 < axis.size(); ++n) {
    const Eigen::Vector2d a = geometry.Project(axis[n]);
    const Eigen::Vector2d b = geometry.Project(axis[n + 1]);
    if (!a.allFinite() || !b.allFinite()) continue;  // Behind the source.
    // The cylinder is at most SDD / distance larger on the detector.
    const double near_mm =
        std::max(1.0, std::min((axis[n] - geometry.source_in_ct_mm()).norm(),
                               (axis[n + 1] - geometry.source_in_ct_mm()).norm()));
    const double reach_px = 1.0 + 1.1 * needle.radius_mm * geometry.source_detector_mm() / near_mm /
                                      std::min(geometry.mm_per_px(), geometry.mm_per_px_down());
    const auto from = [&](double x, int last) {
      return static_cast<int>(std::clamp(std::floor(x - reach_px), 0.0, last + 1.0));
    };
    const auto to = [&](double x, int last) {
      return static_cast<int>(std::clamp(std::ceil(x + reach_px), -1.0, static_cast<double>(last)));
    };
    for (int r = from(std::min(a.y(), b.y()), c_arm.height_px - 1);
         r <= to(std::max(a.y(), b.y()), c_arm.height_px - 1); ++r) {
      for (int c = from(std::min(a.x(), b.x()), c_arm.width_px - 1);
           c <= to(std::max(a.x(), b.x()), c_arm.width_px - 1); ++c) {
        if (DistancePx({c, r}, a, b) > reach_px) continue;
        const int pixel = r * c_arm.width_px + c;
        if (seen_[static_cast<std::size_t>(pixel)] != 0) continue;
        seen_[static_cast<std::size_t>(pixel)] = 1;
        pixels_.push_back(pixel);
      }
    }
  }
  for (const int pixel : pixels_) {
    seen_[static_cast<std::size_t>(pixel)] = 0;
    const int c = pixel % c_arm.width_px;
    const int r = pixel / c_arm.width_px;
    double intensity = 0.0;
    for (int ray = 0; ray < kRaysAcross * kRaysAcross; ++ray) {
      const double dc = (ray % kRaysAcross + 0.5) / kRaysAcross - 0.5;
      const double dr = (ray / kRaysAcross + 0.5) / kRaysAcross - 0.5;
      const Eigen::Vector3d direction =
          (geometry.PixelInCtMm(c + dc, r + dr) - geometry.source_in_ct_mm()).normalized();
      double chord_mm = 0.0;
      for (std::size_t n = 0; n + 1 < axis.size(); ++n) {
        chord_mm += CylinderChordMm(geometry.source_in_ct_mm(), direction, axis[n], axis[n + 1],
                                    needle.radius_mm);
      }
      intensity += std::exp(-c_arm.metal_per_mm * chord_mm);
    }
    // Along the whole needle nothing gets through: keep the sum finite.
    const double mean = std::max(1e-30, intensity / (kRaysAcross * kRaysAcross));
    sums[static_cast<std::ptrdiff_t>(r) * stride + c] -= static_cast<float>(std::log(mean));
  }
}

}  // namespace acus::fluoroscopy
