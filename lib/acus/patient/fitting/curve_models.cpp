#include "acus/patient/fitting/curve_models.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "acus/base/math/statistics.h"

namespace acus::fitting {

void Samples::Add(std::size_t i, double at, double value) {
  index.push_back(i);
  x.push_back(at);
  y.push_back(value);
}

double Samples::Span() const {
  if (x.empty()) return 0.0;
  const auto [low, high] = std::ranges::minmax(x);
  return high - low;
}

Estimate Difference(const Estimate& a, const Estimate& b) {
  const double value = a.value - b.value;
  const double down = std::hypot(a.value - a.low, b.high - b.value);
  const double up = std::hypot(a.high - a.value, b.value - b.low);
  return {value, std::hypot(a.standard_error, b.standard_error), value - down, value + up};
}

Estimate PositiveRatio(const Estimate& a, const Estimate& b, double factor) {
  const double value = factor * a.value / b.value;
  const double error =
      factor * std::hypot(a.standard_error, value / factor * b.standard_error) / b.value;
  if (!(a.value > 0.0)) return {value, error, 0.0, factor * a.high / b.low, 0.0, true};
  const auto ratio = [&](double end, double other_end) {
    const double upper = std::log(end / a.value);
    const double lower = std::log(other_end / b.value);
    return std::exp(std::hypot(upper, lower));
  };
  const double low = a.low > 0.0 ? value / ratio(a.low, b.high) : 0.0;
  return {value, error, low, value * ratio(a.high, b.low), 0.0};
}

Estimate Widened(Estimate estimate, double half) {
  estimate.low -= half;
  estimate.high += half;
  estimate.standard_error = std::hypot(estimate.standard_error, half / std::sqrt(3.0));
  return estimate;
}

SampleModel Line(double middle) {
  return [middle](std::span<const double> p, double x, std::span<double> gradient) {
    gradient[0] = 1.0;
    gradient[1] = x - middle;
    return p[0] + p[1] * (x - middle);
  };
}

ModelFit FitLine(const Samples& samples, double middle) {
  return FitModel(Line(middle), samples.x, samples.y, {math::Median(samples.y), 0.0}, true);
}

double RiseLaw::operator()(std::span<const double> p, double depth_mm,
                           std::span<double> gradient) const {
  const double x = std::max(0.0, depth_mm - p[0]);
  const double a1 = A1(p);
  const double a2 = A2(p);
  gradient[0] = x > 0.0 ? -a1 - 2.0 * a2 * x : 0.0;
  gradient[1] = 1.0;
  if (has_a1) gradient[2] = x;
  if (has_a2) gradient[has_a1 ? 3 : 2] = x * x;
  return p[1] + slope_n_per_mm * (depth_mm - from_mm) + (a1 + a2 * x) * x;
}

SampleModel Relaxation(double start_s) {
  return [start_s](std::span<const double> p, double time_s, std::span<double> gradient) {
    const double u = (time_s - start_s) * std::exp(-p[2]);
    const double decay = std::exp(-u);
    gradient[0] = 1.0;
    gradient[1] = decay;
    gradient[2] = p[1] * decay * u;
    return p[0] + p[1] * decay;
  };
}

std::vector<double> StartOfRise(const Samples& samples, const RiseLaw& law, double to_mm) {
  const std::size_t stride = std::max<std::size_t>(1, samples.x.size() / 400);
  const auto rows = static_cast<Eigen::Index>((samples.x.size() + stride - 1) / stride);
  const Eigen::Index columns = 1 + (law.has_a1 ? 1 : 0) + (law.has_a2 ? 1 : 0);
  Eigen::MatrixXd a(rows, columns);
  Eigen::VectorXd b(rows);
  std::vector<double> best;
  double least = std::numeric_limits<double>::infinity();
  for (int g = 0; g < 60; ++g) {
    const double contact = law.from_mm + (to_mm - law.from_mm) * g / 60.0;
    for (Eigen::Index r = 0; r < rows; ++r) {
      const auto i = static_cast<std::size_t>(r) * stride;
      const double x = std::max(0.0, samples.x[i] - contact);
      a(r, 0) = 1.0;
      if (law.has_a1) a(r, 1) = x;
      if (law.has_a2) a(r, columns - 1) = x * x;
      b(r) = samples.y[i] - law.slope_n_per_mm * (samples.x[i] - law.from_mm);
    }
    const Eigen::VectorXd p = a.colPivHouseholderQr().solve(b);
    const double squares = (a * p - b).squaredNorm();
    if (!(squares < least) || p.tail(columns - 1).minCoeff() < 0.0) continue;
    least = squares;
    best = {contact};
    best.insert(best.end(), p.data(), p.data() + columns);
  }
  return best;
}

}  // namespace acus::fitting
