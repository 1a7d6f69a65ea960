// Implicit shapes: functions that are negative inside, about the distance in mm near the surface.
#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <vector>

namespace acus::phantom {

/// Distance to a shape, mm: < 0 inside, > 0 outside. Exact in sign; in value to first order.
using Distance = std::function<double(const Eigen::Vector3d& point_mm)>;

/// An axis-aligned box that holds a shape.
using Box = Eigen::AlignedBox3d;

struct Shape {
  Distance distance_mm;
  Box bounds_mm;
};

/// Values at knots, monotone cubic between them (Fritsch & Carlson 1980), constant beyond the ends.
class Profile {
 public:
  /// @pre at least two knots, x increasing.
  Profile(std::initializer_list<std::pair<double, double>> knots);
  double operator()(double x) const;
  double Slope(double x) const;

 private:
  std::vector<double> x_, y_, slope_;
};

/// Distance to an axis-aligned ellipsoid at the origin, first order: f / |grad f|.
double EllipsoidDistance(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& radii_mm);

/// Distance to the plane curve |x/a|^2.5 + |y/b|^2.5 = 1 (Lame's curve: a trunk is rounder than a
/// box and squarer than an ellipse), first order.
double SuperellipseDistance(double x_mm, double y_mm, double a_mm, double b_mm);

/// The point of that curve in the direction (a sin(azimuth), b cos(azimuth)).
Eigen::Vector2d SuperellipsePoint(double azimuth_rad, double a_mm, double b_mm);

/// Distance to a box at the origin with rounded edges. @pre rounding <= smallest half size.
double RoundedBoxDistance(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& half_size_mm,
                          double rounding_mm);

/// Distance to a tube from a to b whose radius goes linearly from ra to rb, with round ends.
double CapsuleDistance(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& a_mm,
                       const Eigen::Vector3d& b_mm, double ra_mm, double rb_mm);

/// Union of two distances whose seam is rounded over about `blend_mm` (polynomial smooth minimum).
double SmoothUnion(double a_mm, double b_mm, double blend_mm);

/// Intersection of two distances with its edge rounded over about `blend_mm`.
inline double SmoothIntersection(double a_mm, double b_mm, double blend_mm) {
  return -SmoothUnion(-a_mm, -b_mm, blend_mm);
}

Shape Ellipsoid(const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& radii_mm,
                const Eigen::Matrix3d& rotation = Eigen::Matrix3d::Identity());

/// Chain of capsules through the points.
Shape Tube(std::vector<Eigen::Vector3d> points_mm, std::vector<double> radii_mm);

/// The shape made thicker by `by_mm` on all sides.
Shape Grown(const Shape& shape, double by_mm);

/// The same shape, carried by `ct_from_shape`.
Shape Moved(const Shape& shape, const Eigen::Isometry3d& ct_from_shape);

}  // namespace acus::phantom
