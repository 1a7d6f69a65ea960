#include "acus/patient/registration/error_bound.h"

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"

namespace acus::registration {
namespace {

constexpr int kNodes = 32;          ///< Of each integral.
constexpr int kMixtureNodes = 64;   ///< Of the unknown variance.
constexpr double kThinnest = 1e-4;  ///< Of the largest deviation: a flat covariance gets this much.

double NormalInside(double half_width, double deviation) {
  return std::erf(half_width / (deviation * std::numbers::sqrt2));
}

double NormalDensity(double x, double deviation) {
  return std::exp(-0.5 * x * x / (deviation * deviation)) /
         (deviation * std::sqrt(2.0 * std::numbers::pi));
}

/// Integral of f over [-limit, limit], limit at most eight deviations, where f ends smoothly like a
/// root at +-limit: x = limit sin(t) takes the root out.
template <class F>
double Integrate(double limit, double deviation, const F& f) {
  const double end = std::min(limit, 8.0 * deviation);
  double sum = 0.0;
  for (int i = 0; i < kNodes; ++i) {
    const double t = std::numbers::pi * ((i + 0.5) / kNodes - 0.5);
    sum += std::cos(t) * f(end * std::sin(t));
  }
  return sum * end * std::numbers::pi / kNodes;
}

/// P(|e| < radius) for deviations along the principal axes, smallest first.
double Inside(double radius, const Eigen::Vector3d& deviation) {
  return Integrate(radius, deviation[0], [&](double x) {
    const double rest = std::sqrt(std::max(0.0, radius * radius - x * x));
    return NormalDensity(x, deviation[0]) * Integrate(rest, deviation[1], [&](double y) {
             return NormalDensity(y, deviation[1]) *
                    NormalInside(std::sqrt(std::max(0.0, rest * rest - y * y)), deviation[2]);
           });
  });
}

Eigen::Vector3d Deviations(const Eigen::Matrix3d& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  const Eigen::Vector3d deviation = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  return deviation.cwiseMax(kThinnest * deviation[2]);
}

/// The x where an increasing function is `wanted`, by bisection to a millionth of the range.
template <class F>
double Solve(double low, double high, double wanted, const F& increasing) {
  const double end = 1e-6 * (high - low);
  while (high - low > end) {
    const double middle = 0.5 * (low + high);
    (increasing(middle) < wanted ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

double LengthBoundMm(const Eigen::Matrix3d& covariance_mm2, double confidence) {
  ACUS_ASSERT(confidence > 0.0 && confidence < 1.0);
  const Eigen::Vector3d deviation = Deviations(covariance_mm2);
  if (!(deviation[2] > 0.0)) return 0.0;
  return Solve(0.0, 12.0 * deviation.norm(), confidence,
               [&](double radius) { return Inside(radius, deviation); });
}

double LengthBoundMm(const Eigen::Matrix3d& covariance_mm2, double confidence,
                     double degrees_of_freedom) {
  ACUS_ASSERT(confidence > 0.0 && confidence < 1.0 && degrees_of_freedom > 0.0);
  const Eigen::Vector3d deviation = Deviations(covariance_mm2);
  if (!(deviation[2] > 0.0)) return 0.0;
  // The true deviation is the estimated one times sqrt(k / chi2): the mean over chi2's quantiles.
  std::array<double, kMixtureNodes> factor;
  for (int i = 0; i < kMixtureNodes; ++i) {
    const double chi2 = math::ChiSquareQuantile((i + 0.5) / kMixtureNodes, degrees_of_freedom);
    factor[static_cast<std::size_t>(i)] = std::sqrt(degrees_of_freedom / chi2);
  }
  // Inside() is needed at many radii: a table of it over radius / deviation, read linearly.
  constexpr int kTable = 200;
  const double reach = 8.0 * deviation[2];
  std::array<double, kTable + 1> table;
  for (int i = 0; i <= kTable; ++i) {
    table[static_cast<std::size_t>(i)] = i == 0 ? 0.0 : Inside(reach * i / kTable, deviation);
  }
  const auto inside = [&](double radius) {
    const double place = radius / reach * kTable;
    if (place >= kTable) return 1.0;
    const auto cell = static_cast<std::size_t>(place);
    const double share = place - static_cast<double>(cell);
    return (1.0 - share) * table[cell] + share * table[cell + 1];
  };
  return Solve(0.0, reach * factor[0], confidence, [&](double radius) {
    double sum = 0.0;
    for (const double f : factor) sum += inside(radius / f);
    return sum / kMixtureNodes;
  });
}

DeviationInterval DeviationIntervalOf(double degrees_of_freedom, double confidence) {
  const double tail = 0.5 * (1.0 - confidence);
  return {
      .low =
          std::sqrt(degrees_of_freedom / math::ChiSquareQuantile(1.0 - tail, degrees_of_freedom)),
      .high = std::sqrt(degrees_of_freedom / math::ChiSquareQuantile(tail, degrees_of_freedom))};
}

}  // namespace acus::registration
