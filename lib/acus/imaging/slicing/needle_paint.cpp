#include "acus/imaging/slicing/needle_paint.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"

namespace acus::slicing {
namespace {

/// A bevelled tip is about this many radii long.
constexpr double kTaperRadii = 3.0;

/// What is seen of a needle, projected onto the probe's plane.
struct Shadowgraph {
  Eigen::Vector2d near_mm;  ///< Where the seen part begins, nearer to the tip.
  Eigen::Vector2d along;    ///< Unit, towards the hub.
  double length_mm;         ///< In the plane; 0 if the needle is perpendicular to it.
  double near_s_mm;         ///< Distance from the tip, along the shaft, at both ends.
  double far_s_mm;
  double radius_mm;

  double RadiusAt(double in_plane_mm) const {
    const double share = length_mm > 0.0 ? in_plane_mm / length_mm : 0.5;
    const double s = near_s_mm + share * (far_s_mm - near_s_mm);
    return radius_mm * std::min(1.0, s / (kTaperRadii * radius_mm + 1e-12));
  }
};

/// A straight piece of the shaft.
struct Piece {
  Eigen::Vector3d near_in_ct_mm;  ///< Its end nearer to the tip.
  Eigen::Vector3d axis_in_ct;     ///< Unit, towards the tip.
  double length_mm;
  double from_tip_mm;  ///< Along the shaft, to near_in_ct_mm.
};

/// The part of the piece within `half_slab_mm` of the plane; false if there is none.
bool Project(const Piece& piece, const Eigen::Isometry3d& ct_from_probe, double half_slab_mm,
             double radius_mm, Shadowgraph& seen) {
  const Eigen::Isometry3d probe_from_ct = ct_from_probe.inverse();
  const Eigen::Vector3d tip = probe_from_ct * piece.near_in_ct_mm;
  const Eigen::Vector3d back = -(probe_from_ct.linear() * piece.axis_in_ct);
  double near_s = 0.0;
  double far_s = piece.length_mm;
  if (std::abs(back.z()) < 1e-9) {
    if (std::abs(tip.z()) > half_slab_mm) return false;
  } else {
    const double a = (-half_slab_mm - tip.z()) / back.z();
    const double b = (half_slab_mm - tip.z()) / back.z();
    near_s = std::max(near_s, std::min(a, b));
    far_s = std::min(far_s, std::max(a, b));
    if (near_s > far_s) return false;
  }
  const Eigen::Vector2d in_plane = back.head<2>();
  const double slope = in_plane.norm();
  seen.near_mm = tip.head<2>() + near_s * in_plane;
  seen.along = slope > 1e-6 ? Eigen::Vector2d(in_plane / slope) : Eigen::Vector2d::UnitX();
  seen.length_mm = slope > 1e-6 ? (far_s - near_s) * slope : 0.0;
  seen.near_s_mm = piece.from_tip_mm + near_s;
  seen.far_s_mm = piece.from_tip_mm + far_s;
  seen.radius_mm = radius_mm;
  return true;
}

/// Narrows [low, high] to where offset + slope * t lies in [min, max].
void Narrow(double offset, double slope, double min, double max, double& low, double& high) {
  if (std::abs(slope) < 1e-12) {
    if (offset < min || offset > max) high = low - 1.0;
    return;
  }
  const double a = (min - offset) / slope;
  const double b = (max - offset) / slope;
  low = std::max(low, std::min(a, b));
  high = std::min(high, std::max(a, b));
}

void PaintLine(const Shadowgraph& seen, const acoustics::ScanGrid& grid, int line,
               double half_pixel_mm, BeamImage& hu) {
  const Eigen::Vector2d start = grid.start_mm[static_cast<std::size_t>(line)] - seen.near_mm;
  const Eigen::Vector2d step = grid.step_mm * grid.direction[static_cast<std::size_t>(line)];
  const Eigen::Vector2d across(-seen.along.y(), seen.along.x());
  const double reach = std::max(seen.radius_mm, half_pixel_mm);
  double low = 0.0;
  double high = grid.samples - 1.0;
  Narrow(across.dot(start), across.dot(step), -reach, reach, low, high);
  Narrow(seen.along.dot(start), seen.along.dot(step), -reach, seen.length_mm + reach, low, high);
  if (!(low <= high)) return;
  for (int k = static_cast<int>(std::ceil(low)); k <= static_cast<int>(std::floor(high)); ++k) {
    const Eigen::Vector2d at = start + k * step;
    const double along = seen.along.dot(at);
    const double nearest = std::clamp(along, 0.0, seen.length_mm);
    const double distance = std::hypot(across.dot(at), along - nearest);
    if (distance <= std::max(half_pixel_mm, seen.RadiusAt(nearest))) hu.row(k)[line] = kNeedleHu;
  }
}

void PaintPiece(const Piece& piece, double radius_mm, const Eigen::Isometry3d& ct_from_probe,
                double slice_thickness_mm, const acoustics::ScanGrid& grid, BeamImage& hu) {
  Shadowgraph seen;
  if (!Project(piece, ct_from_probe, 0.5 * slice_thickness_mm + radius_mm, radius_mm, seen)) return;
  const double lateral_mm = grid.lines() > 1 ? grid.LateralSpacingMm(grid.samples - 1) : 0.0;
  const double half_pixel_mm = 0.5 * std::max(grid.step_mm, lateral_mm);
  for (int line = 0; line < grid.lines(); ++line) PaintLine(seen, grid, line, half_pixel_mm, hu);
}

}  // namespace

void PaintNeedle(const image::NeedleInImage& needle, const Eigen::Isometry3d& ct_from_probe,
                 double slice_thickness_mm, const acoustics::ScanGrid& grid, BeamImage& hu) {
  ACUS_REQUIRE(std::isfinite(needle.radius_mm) && needle.radius_mm >= 0.0,
               "needle in the image: radius ", needle.radius_mm, " mm; it may not be negative");
  const math::Polyline& shape = needle.shape;
  if (shape.num_points >= 2) {
    double from_tip_mm = 0.0;
    for (int i = 1; i < shape.num_points; ++i) {
      const Eigen::Vector3d step_mm = shape.At(i - 1) - shape.At(i);
      const double length_mm = step_mm.norm();
      ACUS_REQUIRE(std::isfinite(length_mm) && shape.At(i).allFinite(),
                   "needle in the image: point ", i, " of its shape is not finite");
      if (length_mm == 0.0) continue;
      PaintPiece({shape.At(i - 1), step_mm / length_mm, length_mm, from_tip_mm}, needle.radius_mm,
                 ct_from_probe, slice_thickness_mm, grid, hu);
      from_tip_mm += length_mm;
    }
    return;
  }
  ACUS_REQUIRE(needle.tip_in_ct_mm.allFinite() && needle.axis_in_ct.allFinite() &&
                   std::isfinite(needle.length_mm),
               "needle in the image: has a value that is not finite");
  ACUS_REQUIRE(needle.axis_in_ct.norm() > 1e-6, "needle in the image: its axis has no direction");
  ACUS_REQUIRE(needle.length_mm >= 0.0, "needle in the image: length ", needle.length_mm,
               " mm; it may not be negative");
  PaintPiece({needle.tip_in_ct_mm, needle.axis_in_ct.normalized(), needle.length_mm, 0.0},
             needle.radius_mm, ct_from_probe, slice_thickness_mm, grid, hu);
}

}  // namespace acus::slicing
