#include "acus/patient/phantom/anatomy/shapes.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "acus/base/core/error.h"

namespace acus::phantom {

Profile::Profile(std::initializer_list<std::pair<double, double>> knots) {
  ACUS_ASSERT(knots.size() >= 2);
  for (const auto& [x, y] : knots) {
    ACUS_ASSERT(x_.empty() || x > x_.back());
    x_.push_back(x);
    y_.push_back(y);
  }
  const std::size_t n = x_.size();
  std::vector<double> secant(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) secant[i] = (y_[i + 1] - y_[i]) / (x_[i + 1] - x_[i]);
  slope_.assign(n, 0.0);  // Flat at both ends, so that the constant continuation is smooth.
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (secant[i - 1] * secant[i] <= 0.0) continue;
    // The harmonic mean keeps the curve monotone between knots.
    slope_[i] = 2.0 * secant[i - 1] * secant[i] / (secant[i - 1] + secant[i]);
  }
}

double Profile::operator()(double x) const {
  if (x <= x_.front()) return y_.front();
  if (x >= x_.back()) return y_.back();
  const auto i = static_cast<std::size_t>(std::ranges::upper_bound(x_, x) - x_.begin()) - 1;
  const double h = x_[i + 1] - x_[i];
  const double t = (x - x_[i]) / h;
  const double u = 1.0 - t;
  return u * u * ((1.0 + 2.0 * t) * y_[i] + t * h * slope_[i]) +
         t * t * ((3.0 - 2.0 * t) * y_[i + 1] - u * h * slope_[i + 1]);
}

double Profile::Slope(double x) const {
  constexpr double kStep = 0.01;
  return ((*this)(x + kStep) - (*this)(x - kStep)) / (2.0 * kStep);
}

double EllipsoidDistance(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& radii_mm) {
  const double r = point_mm.cwiseQuotient(radii_mm).norm();
  const double gradient = point_mm.cwiseQuotient(radii_mm.cwiseAbs2()).norm();
  if (gradient < 1e-9) return -radii_mm.minCoeff();
  return r * (r - 1.0) / gradient;
}

double SuperellipseDistance(double x_mm, double y_mm, double a_mm, double b_mm) {
  const double u = std::abs(x_mm) / a_mm;
  const double v = std::abs(y_mm) / b_mm;
  const double u15 = u * std::sqrt(u);
  const double v15 = v * std::sqrt(v);
  const double sum = u15 * u + v15 * v;
  if (sum < 1e-9) return -std::min(a_mm, b_mm);
  return (sum - 1.0) / (2.5 * std::sqrt((u15 / a_mm) * (u15 / a_mm) + (v15 / b_mm) * (v15 / b_mm)));
}

Eigen::Vector2d SuperellipsePoint(double azimuth_rad, double a_mm, double b_mm) {
  const double s = std::sin(azimuth_rad);
  const double c = std::cos(azimuth_rad);
  const double sum = s * s * std::sqrt(std::abs(s)) + c * c * std::sqrt(std::abs(c));
  const double r = std::pow(sum, -0.4);
  return {r * a_mm * s, r * b_mm * c};
}

double RoundedBoxDistance(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& half_size_mm,
                          double rounding_mm) {
  const Eigen::Vector3d q =
      point_mm.cwiseAbs() - half_size_mm + Eigen::Vector3d::Constant(rounding_mm);
  return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - rounding_mm;
}

double CapsuleDistance(const Eigen::Vector3d& point_mm, const Eigen::Vector3d& a_mm,
                       const Eigen::Vector3d& b_mm, double ra_mm, double rb_mm) {
  const Eigen::Vector3d axis = b_mm - a_mm;
  const double t = std::clamp((point_mm - a_mm).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
  return (point_mm - a_mm - t * axis).norm() - (ra_mm + t * (rb_mm - ra_mm));
}

double SmoothUnion(double a_mm, double b_mm, double blend_mm) {
  const double overlap = std::max(blend_mm - std::abs(a_mm - b_mm), 0.0) / blend_mm;
  return std::min(a_mm, b_mm) - overlap * overlap * blend_mm * 0.25;
}

Shape Ellipsoid(const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& radii_mm,
                const Eigen::Matrix3d& rotation) {
  const Eigen::Matrix3d inverse = rotation.transpose();
  const Eigen::Vector3d reach =
      (rotation * radii_mm.asDiagonal()).rowwise().norm();  // Half size of the tight box.
  return {[=](const Eigen::Vector3d& p) {
            return EllipsoidDistance(inverse * (p - centre_mm), radii_mm);
          },
          Box(centre_mm - reach, centre_mm + reach)};
}

Shape Tube(std::vector<Eigen::Vector3d> points_mm, std::vector<double> radii_mm) {
  ACUS_ASSERT(points_mm.size() >= 2 && points_mm.size() == radii_mm.size());
  Box bounds;
  for (std::size_t i = 0; i < points_mm.size(); ++i) {
    bounds.extend(points_mm[i] - Eigen::Vector3d::Constant(radii_mm[i]));
    bounds.extend(points_mm[i] + Eigen::Vector3d::Constant(radii_mm[i]));
  }
  return {[points = std::move(points_mm), radii = std::move(radii_mm)](const Eigen::Vector3d& p) {
            double nearest = 1e9;
            for (std::size_t i = 0; i + 1 < points.size(); ++i) {
              nearest = std::min(
                  nearest, CapsuleDistance(p, points[i], points[i + 1], radii[i], radii[i + 1]));
            }
            return nearest;
          },
          bounds};
}

Shape Grown(const Shape& shape, double by_mm) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(by_mm);
  return {[inner = shape.distance_mm, by_mm](const Eigen::Vector3d& p) { return inner(p) - by_mm; },
          Box(shape.bounds_mm.min() - margin, shape.bounds_mm.max() + margin)};
}

Shape Moved(const Shape& shape, const Eigen::Isometry3d& ct_from_shape) {
  const Eigen::Isometry3d shape_from_ct = ct_from_shape.inverse();
  return {[inner = shape.distance_mm, shape_from_ct](const Eigen::Vector3d& p) {
            return inner(shape_from_ct * p);
          },
          shape.bounds_mm.transformed(ct_from_shape)};
}

}  // namespace acus::phantom
