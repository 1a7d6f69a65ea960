// One element of the rod: an arc of constant curvature and twist (a piece of a helix).
//
// Along an element the frame turns by w, rad/mm, given in world axes: R(s) = exp(s [w]x) R(0), so
//   d(s) = x(s) - x(0) = s J(s w) t,   J(v) = I + alpha [v]x + beta [v]x^2
// with J the left Jacobian of the rotation group, alpha = (1 - cos a) / a^2,
// beta = (a - sin a) / a^3, a = |v|, and t the tangent at the element's start. No approximation.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

namespace acus::needle {

/// alpha, beta and their derivatives with respect to a^2, for the turn v = s w.
struct ArcTerms {
  double length_mm = 0.0;                              ///< s
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< v
  double alpha = 0.5, beta = 1.0 / 6.0;
  double alpha_slope = -1.0 / 24.0, beta_slope = -1.0 / 120.0;
};

/// Below this a^2 (0.7 rad) the series have an error under 1e-13; above it the closed forms do not
/// lose digits.
inline constexpr double kSeriesTurn2 = 0.5;

inline ArcTerms ArcTermsOf(double length_mm, const Eigen::Vector3d& w_per_mm) noexcept {
  ArcTerms arc;
  arc.length_mm = length_mm;
  arc.turn_rad = length_mm * w_per_mm;
  const double y = arc.turn_rad.squaredNorm();
  if (y < kSeriesTurn2) {
    arc.alpha =
        1. / 2 -
        y * (1. / 24 - y * (1. / 720 - y * (1. / 40320 - y * (1. / 3628800 - y / 479001600))));
    arc.beta =
        1. / 6 - y * (1. / 120 -
                      y * (1. / 5040 - y * (1. / 362880 - y * (1. / 39916800 - y / 6227020800.))));
    arc.alpha_slope =
        -1. / 24 + y * (1. / 360 - y * (1. / 13440 - y * (1. / 907200 - y / 95800320)));
    arc.beta_slope =
        -1. / 120 + y * (1. / 2520 - y * (1. / 120960 - y * (1. / 9979200 - y / 1245404160)));
    return arc;
  }
  const double a = std::sqrt(y);
  const double one_minus_cos = 1.0 - std::cos(a);
  const double sine = std::sin(a);
  arc.alpha = one_minus_cos / y;
  arc.beta = (a - sine) / (a * y);
  arc.alpha_slope = (0.5 * a * sine - one_minus_cos) / (y * y);
  arc.beta_slope = (a * one_minus_cos - 3.0 * (a - sine)) / (2.0 * a * y * y);
  return arc;
}

/// d = s J(v) t.
inline Eigen::Vector3d ArcChord(const ArcTerms& arc, const Eigen::Vector3d& tangent) noexcept {
  const Eigen::Vector3d vt = arc.turn_rad.cross(tangent);
  return arc.length_mm * (tangent + arc.alpha * vt + arc.beta * arc.turn_rad.cross(vt));
}

/// (d d / d w)^T n: what a force n at the arc's end does on its curvature.
inline Eigen::Vector3d ChordAdjoint(const ArcTerms& arc, const Eigen::Vector3d& t,
                                    const Eigen::Vector3d& n) noexcept {
  const Eigen::Vector3d& v = arc.turn_rad;
  const Eigen::Vector3d vt = v.cross(t);
  const double along = 2.0 * (arc.alpha_slope * vt.dot(n) + arc.beta_slope * v.cross(vt).dot(n)) -
                       2.0 * arc.beta * t.dot(n);
  return arc.length_mm * arc.length_mm *
         (arc.alpha * t.cross(n) + arc.beta * (v.dot(t) * n + v.dot(n) * t) + along * v);
}

/// (s J(v))^T m: what a moment m at the arc's end does on its curvature.
inline Eigen::Vector3d TurnAdjoint(const ArcTerms& arc, const Eigen::Vector3d& m) noexcept {
  const Eigen::Vector3d vm = arc.turn_rad.cross(m);
  return arc.length_mm * (m - arc.alpha * vm + arc.beta * arc.turn_rad.cross(vm));
}

inline Eigen::Matrix3d CrossMatrix(const Eigen::Vector3d& a) noexcept {
  Eigen::Matrix3d cross;
  cross << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return cross;
}

/// d d / d w, 3 x 3.
inline Eigen::Matrix3d ChordSlope(const ArcTerms& arc, const Eigen::Vector3d& t) noexcept {
  const Eigen::Vector3d& v = arc.turn_rad;
  const Eigen::Vector3d vt = v.cross(t);
  const Eigen::Vector3d column =
      2.0 * (arc.alpha_slope * vt + arc.beta_slope * v.cross(vt) - arc.beta * t);
  Eigen::Matrix3d slope = CrossMatrix(-arc.alpha * t);
  slope.diagonal().array() += arc.beta * v.dot(t);
  slope += column * v.transpose() + (arc.beta * v) * t.transpose();
  return arc.length_mm * arc.length_mm * slope;
}

/// s J(v): how the end of the arc turns with w, 3 x 3.
inline Eigen::Matrix3d TurnSlope(const ArcTerms& arc) noexcept {
  const Eigen::Vector3d& v = arc.turn_rad;
  Eigen::Matrix3d slope = CrossMatrix(arc.alpha * v);
  slope += (arc.beta * v) * v.transpose();
  slope.diagonal().array() += 1.0 - arc.beta * v.squaredNorm();
  return arc.length_mm * slope;
}

/// exp(v) as a unit quaternion.
inline Eigen::Quaterniond TurnQuaternion(const Eigen::Vector3d& v) noexcept {
  const double y = v.squaredNorm();
  double cosine = 0.0;
  double sine_per_rad = 0.0;
  if (y < kSeriesTurn2) {
    cosine = 1. - y * (1. / 8 -
                       y * (1. / 384 - y * (1. / 46080 - y * (1. / 10321920 - y / 3715891200.))));
    sine_per_rad =
        1. / 2 - y * (1. / 48 - y * (1. / 3840 -
                                     y * (1. / 645120 - y * (1. / 185794560 - y / 81749606400.))));
  } else {
    const double a = std::sqrt(y);
    cosine = std::cos(0.5 * a);
    sine_per_rad = std::sin(0.5 * a) / a;
  }
  return {cosine, sine_per_rad * v.x(), sine_per_rad * v.y(), sine_per_rad * v.z()};
}

/// The third axis of the frame: the tangent.
inline Eigen::Vector3d TangentOf(const Eigen::Quaterniond& q) noexcept {
  return {2.0 * (q.x() * q.z() + q.w() * q.y()), 2.0 * (q.y() * q.z() - q.w() * q.x()),
          1.0 - 2.0 * (q.x() * q.x() + q.y() * q.y())};
}

}  // namespace acus::needle
