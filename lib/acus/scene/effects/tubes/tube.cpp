#include "acus/scene/effects/tubes/tube.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/core/error.h"

namespace acus::effects {
namespace {

/// Squared distances from the axis of a ring of tissue, mm^2: at the wall at rest, from there to
/// the reach, and the increase at the wall after it has moved.
struct Ring {
  double wall_mm2;
  double width_mm2;
  double grown_mm2;
};

Ring RingOf(double radius_mm, double reach_mm, double strain) noexcept {
  const double reached_mm = radius_mm + reach_mm;
  const double moved_mm = radius_mm * (1.0 + strain);
  const double wall_mm2 = radius_mm * radius_mm;
  return {wall_mm2, reached_mm * reached_mm - wall_mm2, moved_mm * moved_mm - wall_mm2};
}

/// The point at another distance from the axis, in the same direction.
Eigen::Vector3d AtDistance(const Eigen::Vector3d& place_mm, const Eigen::Vector3d& axis_mm,
                           double from_mm, double to_mm) noexcept {
  return axis_mm + (to_mm / from_mm) * (place_mm - axis_mm);
}

}  // namespace

double Centreline::LengthMm() const {
  double length_mm = 0.0;
  for (std::size_t i = 1; i < point_in_ct_mm.size(); ++i) {
    length_mm += (point_in_ct_mm[i] - point_in_ct_mm[i - 1]).norm();
  }
  return length_mm;
}

Centreline Resampled(const Centreline& line, double spacing_mm) {
  const double length_mm = line.LengthMm();
  const int pieces = std::max(1, static_cast<int>(std::ceil(length_mm / spacing_mm)));
  Centreline out;
  std::size_t piece = 1;
  double before_mm = 0.0;
  for (int n = 0; n <= pieces; ++n) {
    const double at_mm = length_mm * n / pieces;
    const auto piece_mm = [&] {
      return (line.point_in_ct_mm[piece] - line.point_in_ct_mm[piece - 1]).norm();
    };
    while (piece + 1 < line.point_in_ct_mm.size() && before_mm + piece_mm() < at_mm) {
      before_mm += piece_mm();
      ++piece;
    }
    const double share =
        piece_mm() > 0.0 ? std::clamp((at_mm - before_mm) / piece_mm(), 0.0, 1.0) : 0.0;
    out.point_in_ct_mm.emplace_back((1.0 - share) * line.point_in_ct_mm[piece - 1] +
                                    share * line.point_in_ct_mm[piece]);
    out.radius_mm.push_back((1.0 - share) * line.radius_mm[piece - 1] +
                            share * line.radius_mm[piece]);
  }
  return out;
}

Tube::Tube(Centreline line, double reach_mm, double largest_strain)
    : line_(std::move(line)), reach_mm_(reach_mm) {
  ACUS_REQUIRE(
      line_.point_in_ct_mm.size() >= 2 && line_.radius_mm.size() == line_.point_in_ct_mm.size(),
      "a tube has ", line_.point_in_ct_mm.size(), " points and ", line_.radius_mm.size(),
      " radii; at least two points are needed, with a radius each");
  along_mm_.assign(1, 0.0);
  for (std::size_t i = 1; i < line_.point_in_ct_mm.size(); ++i) {
    along_mm_.push_back(along_mm_.back() +
                        (line_.point_in_ct_mm[i] - line_.point_in_ct_mm[i - 1]).norm());
  }
  low_mm_.setConstant(std::numeric_limits<double>::infinity());
  high_mm_ = -low_mm_;
  for (std::size_t i = 0; i < line_.radius_mm.size(); ++i) {
    const double radius_mm = line_.radius_mm[i];
    ACUS_REQUIRE(line_.point_in_ct_mm[i].allFinite() && std::isfinite(radius_mm) && radius_mm > 0.0,
                 "point ", i, " of a tube is not finite, or its radius of ", radius_mm,
                 " mm is not above 0");
    const Ring ring = RingOf(radius_mm, reach_mm, largest_strain);
    ACUS_REQUIRE(ring.grown_mm2 < 0.5 * ring.width_mm2, "a tube of radius ", radius_mm,
                 " mm whose wall moves by ", largest_strain, " of it would fold the tissue within ",
                 reach_mm, " mm; give a larger reach_mm or a smaller strain");
    const Eigen::Vector3d reached_mm = Eigen::Vector3d::Constant(radius_mm + reach_mm);
    low_mm_ = low_mm_.cwiseMin(line_.point_in_ct_mm[i] - reached_mm);
    high_mm_ = high_mm_.cwiseMax(line_.point_in_ct_mm[i] + reached_mm);
  }
}

double Tube::LargestRadiusMm() const {
  return std::ranges::max(line_.radius_mm);
}

bool Tube::FindNearest(const Eigen::Vector3d& place_in_ct_mm, Nearest& out) const noexcept {
  // Also false for a point that is not finite.
  if (!((place_in_ct_mm.array() >= low_mm_.array()) && (place_in_ct_mm.array() <= high_mm_.array()))
           .all()) {
    return false;
  }
  double least_mm2 = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < line_.point_in_ct_mm.size(); ++i) {
    const Eigen::Vector3d& begin_mm = line_.point_in_ct_mm[i - 1];
    const Eigen::Vector3d piece_mm = line_.point_in_ct_mm[i] - begin_mm;
    const double along_mm2 = piece_mm.dot(place_in_ct_mm - begin_mm);
    const double length_mm2 = piece_mm.squaredNorm();
    const double share = length_mm2 > 0.0 ? std::clamp(along_mm2 / length_mm2, 0.0, 1.0) : 0.0;
    const Eigen::Vector3d axis_mm = begin_mm + share * piece_mm;
    const double mm2 = (place_in_ct_mm - axis_mm).squaredNorm();
    if (mm2 >= least_mm2) continue;
    least_mm2 = mm2;
    out.axis_mm = axis_mm;
    out.along_mm = (1.0 - share) * along_mm_[i - 1] + share * along_mm_[i];
    out.radius_mm = (1.0 - share) * line_.radius_mm[i - 1] + share * line_.radius_mm[i];
  }
  out.distance_mm = std::sqrt(least_mm2);
  return out.distance_mm > 0.0 && out.distance_mm < out.radius_mm + reach_mm_;
}

Eigen::Vector3d Tube::RestMm(const Eigen::Vector3d& place_in_ct_mm, double strain) const noexcept {
  Nearest near;
  if (strain == 0.0 || !FindNearest(place_in_ct_mm, near)) return place_in_ct_mm;
  return RestMm(place_in_ct_mm, near, strain);
}

Eigen::Vector3d Tube::RestMm(const Eigen::Vector3d& place_in_ct_mm, const Nearest& near,
                             double strain) const noexcept {
  if (strain == 0.0) return place_in_ct_mm;
  const double wall_mm = near.radius_mm * (1.0 + strain);
  if (near.distance_mm <= wall_mm) {
    return AtDistance(place_in_ct_mm, near.axis_mm, wall_mm, near.radius_mm);
  }
  // s' = s + c y^2 with y = 1 - x = (S - s) / L, the root that goes with c to (S - s') / L.
  const Ring ring = RingOf(near.radius_mm, reach_mm_, strain);
  const double left_mm2 = ring.wall_mm2 + ring.width_mm2 - near.distance_mm * near.distance_mm;
  const double root_mm2 =
      std::sqrt(ring.width_mm2 * ring.width_mm2 - 4.0 * ring.grown_mm2 * left_mm2);
  const double y = 2.0 * left_mm2 / (ring.width_mm2 + root_mm2);
  const double rest_mm2 = ring.wall_mm2 + ring.width_mm2 * (1.0 - y);
  return AtDistance(place_in_ct_mm, near.axis_mm, near.distance_mm, std::sqrt(rest_mm2));
}

Eigen::Vector3d Tube::WorldMm(const Eigen::Vector3d& rest_in_ct_mm, double strain) const noexcept {
  Nearest near;
  if (strain == 0.0 || !FindNearest(rest_in_ct_mm, near)) return rest_in_ct_mm;
  const double wall_mm = near.radius_mm * (1.0 + strain);
  if (near.distance_mm <= near.radius_mm) {
    return AtDistance(rest_in_ct_mm, near.axis_mm, near.radius_mm, wall_mm);
  }
  const Ring ring = RingOf(near.radius_mm, reach_mm_, strain);
  const double rest_mm2 = near.distance_mm * near.distance_mm;
  const double y = 1.0 - (rest_mm2 - ring.wall_mm2) / ring.width_mm2;
  return AtDistance(rest_in_ct_mm, near.axis_mm, near.distance_mm,
                    std::sqrt(rest_mm2 + ring.grown_mm2 * y * y));
}

}  // namespace acus::effects
