#include "acus/physics/forces/laws/hu_resistance.h"

#include <algorithm>

#include "acus/base/core/error.h"

namespace acus::forces {

CubicBSpline::CubicBSpline(const std::vector<double>& breakpoints,
                           const std::vector<double>& coefficients, const std::string& where)
    : coefficient_(coefficients) {
  ACUS_REQUIRE(breakpoints.size() >= 2, where, ": needs two breakpoints or more, has ",
               breakpoints.size());
  for (std::size_t i = 1; i < breakpoints.size(); ++i) {
    ACUS_REQUIRE(breakpoints[i] > breakpoints[i - 1], where, ": breakpoint ", i, " is ",
                 breakpoints[i], "; it must be above the one before, ", breakpoints[i - 1]);
  }
  ACUS_REQUIRE(coefficients.size() == breakpoints.size() + 2, where, ": ", breakpoints.size(),
               " breakpoints need ", breakpoints.size() + 2, " coefficients, there are ",
               coefficients.size());
  knot_.assign(3, breakpoints.front());
  knot_.insert(knot_.end(), breakpoints.begin(), breakpoints.end());
  knot_.insert(knot_.end(), 3, breakpoints.back());
}

int CubicBSpline::Basis(double x, double basis[4]) const noexcept {
  const int last_span = num_coefficients() - 1;
  x = std::clamp(x, knot_.front(), knot_.back());
  int span = 3;
  while (span < last_span && x >= knot_[span + 1]) ++span;
  // Cox and de Boor, upwards from the one constant function that is not 0 here.
  basis[0] = 1.0;
  for (int degree = 1; degree <= 3; ++degree) {
    double carried = 0.0;
    for (int k = 0; k < degree; ++k) {
      const double right = knot_[span + k + 1];
      const double left = knot_[span + k + 1 - degree];
      const double share = basis[k] / (right - left);
      basis[k] = carried + (right - x) * share;
      carried = (x - left) * share;
    }
    basis[degree] = carried;
  }
  return span - 3;
}

double CubicBSpline::operator()(double x) const noexcept {
  double basis[4];
  const int first = Basis(x, basis);
  double value = 0.0;
  for (int k = 0; k < 4; ++k) value += basis[k] * coefficient_[first + k];
  return value;
}

CubicBSpline CubicBSpline::operator*(double factor) const {
  CubicBSpline scaled = *this;
  for (double& value : scaled.coefficient_) value *= factor;
  return scaled;
}

}  // namespace acus::forces
