// A smooth function of Hounsfield units: a clamped cubic B-spline, Vidal-2008 section 3.3.2.
#pragma once

#include <string>
#include <vector>

namespace acus::forces {

/// value(x) = sum of coefficient[i] B_i(x); constant beyond the ends. With m breakpoints there are
/// m + 2 coefficients. It lies between the smallest and the largest coefficient around x, so
/// coefficients >= 0 give values >= 0; it is linear in them, so that they can be fitted directly.
class CubicBSpline {
 public:
  /// Zero everywhere.
  CubicBSpline() : CubicBSpline({0.0, 1.0}, {0.0, 0.0, 0.0, 0.0}, "") {}

  /// @throws InputError, in the name of `where`, if the breakpoints do not rise or the numbers do
  ///     not match.
  CubicBSpline(const std::vector<double>& breakpoints, const std::vector<double>& coefficients,
               const std::string& where);

  double operator()(double x) const noexcept;

  /// Values of the basis functions at x: `basis[k]` is that of coefficient `first + k`; the others
  /// are 0. @return first.
  int Basis(double x, double basis[4]) const noexcept;

  CubicBSpline operator*(double factor) const;
  int num_coefficients() const { return static_cast<int>(coefficient_.size()); }

 private:
  std::vector<double> knot_;  ///< Each end four times.
  std::vector<double> coefficient_;
};

}  // namespace acus::forces
