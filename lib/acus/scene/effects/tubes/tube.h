// A tube of soft tissue whose wall moves: outwards, as an artery's in systole, or inwards, as the
// bowel's. The surrounding tissue moves with it. Equations: docs/models/pulsating_vessels.md.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace acus::effects {

/// The centreline of a tube at rest, and the radius of its wall.
struct Centreline {
  std::vector<Eigen::Vector3d> point_in_ct_mm;  ///< At least two.
  std::vector<double> radius_mm;                ///< At each point; above 0.

  double LengthMm() const;
};

/// The same line with points at equal distances of at most `spacing_mm`; its ends stay.
/// @pre spacing_mm > 0.
Centreline Resampled(const Centreline& line, double spacing_mm);

/// Radial motion about a centreline. With s the squared distance from the line at rest and
/// c = (R + u)^2 - R^2 for a wall that has moved by u, tissue goes to s + c (1 - x)^2, where x runs
/// from 0 at the wall to 1 at the reach: an incompressible ring that fades out. The lumen is filled
/// in proportion. Both directions have a closed form. A value; const access from any thread.
class Tube {
 public:
  /// The point of the centreline that is nearest to a query point.
  struct Nearest {
    Eigen::Vector3d axis_mm;   ///< On the line.
    double along_mm = 0.0;     ///< Arc length from the line's first point.
    double distance_mm = 0.0;  ///< From the query point to the line.
    double radius_mm = 0.0;    ///< Radius of the wall at rest.
  };

  /// @throws InputError if the line has fewer than two points, a number is not finite or a radius
  ///     not above 0, or for a reach that does not leave the tissue room for `largest_strain`: it
  ///     would fold. reach_mm is beyond the wall.
  Tube(Centreline line, double reach_mm, double largest_strain);

  /// False if the point is beyond the reach of the whole tube.
  bool FindNearest(const Eigen::Vector3d& place_in_ct_mm, Nearest& out) const noexcept;

  /// The rest position of the tissue that is now at a point.
  /// @param strain  Strain of the radius, above -1 and up to largest_strain.
  Eigen::Vector3d RestMm(const Eigen::Vector3d& place_in_ct_mm, double strain) const noexcept;
  /// The same for a strain of the nearest part of the wall. @param near  As FindNearest gives it.
  Eigen::Vector3d RestMm(const Eigen::Vector3d& place_in_ct_mm, const Nearest& near,
                         double strain) const noexcept;
  /// The inverse of the first RestMm.
  Eigen::Vector3d WorldMm(const Eigen::Vector3d& rest_in_ct_mm, double strain) const noexcept;

  const Centreline& line() const { return line_; }
  double LargestRadiusMm() const;

 private:
  Centreline line_;
  std::vector<double> along_mm_;  ///< Arc length at each point.
  double reach_mm_;
  Eigen::Vector3d low_mm_;  ///< Box of all tissue that moves.
  Eigen::Vector3d high_mm_;
};

}  // namespace acus::effects
