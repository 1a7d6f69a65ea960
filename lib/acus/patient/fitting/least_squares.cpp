#include "acus/patient/fitting/least_squares.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"
#include "acus/base/math/statistics.h"

namespace acus::fitting {
namespace {

constexpr double kHuberDeviations = 2.5;
/// Fewer than this are not known well enough to widen an interval by.
constexpr double kLeastDegrees = 3.0;
constexpr std::size_t kLongestLag = 5000;  // Bounds the work on very long recordings.

/// All samples in one residual block: the model is cheap, Ceres' bookkeeping per block is not.
/// residual [N] = sqrt(weight) (model - measured).
class SampleCost : public ceres::CostFunction {
 public:
  SampleCost(const SampleModel& model, std::span<const double> x, std::span<const double> y,
             const std::vector<double>& weight, int num_parameters)
      : model_(model), x_(x), y_(y), weight_(weight) {
    set_num_residuals(static_cast<int>(x.size()));
    mutable_parameter_block_sizes()->push_back(num_parameters);
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const auto n = static_cast<std::size_t>(parameter_block_sizes()[0]);
    std::vector<double> gradient(n);
    for (std::size_t i = 0; i < x_.size(); ++i) {
      const double root = std::sqrt(weight_[i]);
      residuals[i] = root * (model_({parameters[0], n}, x_[i], gradient) - y_[i]);
      if (!std::isfinite(residuals[i])) return false;
      if (jacobians == nullptr || jacobians[0] == nullptr) continue;
      for (std::size_t k = 0; k < n; ++k) jacobians[0][i * n + k] = root * gradient[k];
    }
    return true;
  }

 private:
  const SampleModel& model_;
  std::span<const double> x_;
  std::span<const double> y_;
  const std::vector<double>& weight_;
};

ceres::Solver::Summary Solve(const SampleCost& cost, std::vector<double>& parameters) {
  ceres::Problem::Options problem_options;
  problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(problem_options);
  problem.AddResidualBlock(const_cast<SampleCost*>(&cost), nullptr, parameters.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;  // More threads would sum in another order: other last bits.
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-14;
  options.parameter_tolerance = 1e-11;
  options.gradient_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary;
}

std::vector<double> Residuals(const SampleModel& model, std::span<const double> x,
                              std::span<const double> y, const std::vector<double>& parameters) {
  std::vector<double> gradient(parameters.size());
  std::vector<double> residual(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) residual[i] = model(parameters, x[i], gradient) - y[i];
  return residual;
}

void AddCovariance(const SampleModel& model, std::span<const double> x,
                   const std::vector<double>& weight, const std::vector<double>& residual,
                   ModelFit& fit) {
  const auto n = static_cast<Eigen::Index>(fit.parameters.size());
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd gradient(n);
  std::vector<double> weighted(residual.size());
  double squares = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    model(fit.parameters, x[i], {gradient.data(), static_cast<std::size_t>(n)});
    normal.selfadjointView<Eigen::Lower>().rankUpdate(gradient, weight[i]);
    weighted[i] = weight[i] * residual[i];
    squares += weight[i] * residual[i] * residual[i];
  }
  const double degrees = static_cast<double>(x.size()) - static_cast<double>(n);
  fit.inflation = Inflation(weighted);
  fit.effective_samples = static_cast<double>(x.size()) / fit.inflation;
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal.selfadjointView<Eigen::Lower>());
  const bool full_rank = solver.isPositive() && solver.rcond() > 1e-15;
  fit.converged = fit.converged && full_rank;
  if (!full_rank) fit.message = "the samples do not determine all parameters";
  fit.covariance =
      squares / degrees * fit.inflation * solver.solve(Eigen::MatrixXd::Identity(n, n));
}

}  // namespace

double Inflation(std::span<const double> residual) {
  const std::size_t n = residual.size();
  double variance = 0.0;
  for (const double r : residual) variance += r * r;
  if (!(variance > 0.0)) return 1.0;
  double sum = 1.0;
  for (std::size_t lag = 1; lag < std::min(n / 4, kLongestLag); ++lag) {
    double product = 0.0;
    for (std::size_t i = 0; i + lag < n; ++i) product += residual[i] * residual[i + lag];
    if (product <= 0.0) break;
    sum += 2.0 * product / variance;
  }
  return sum;
}

nlohmann::json EstimateJson(const Estimate& estimate) {
  nlohmann::json block = {{"value", estimate.value},
                          {"standard_error", estimate.standard_error},
                          {"low_95", estimate.low},
                          {"high_95", estimate.high}};
  if (estimate.at_bound) block["at_bound"] = true;
  return block;
}

Estimate Estimate::Normal(double value, double standard_error) {
  const double half_width = math::NormalQuantile(0.975) * standard_error;
  return {value, standard_error, value - half_width, value + half_width};
}

Estimate Estimate::AtLeast(double bound) const {
  Estimate result = *this;
  result.least = std::max(least, bound);
  result.low = std::max(low, bound);
  if (value >= bound) return result;
  result.value = bound;
  result.high = value + std::hypot(bound - value, high - value);
  result.at_bound = true;
  return result;
}

Estimate Estimate::AmongSeveral(int num_intervals) const {
  const double joint = math::NormalQuantile(1.0 - 0.025 / std::max(1, num_intervals));
  const double wider = joint / math::NormalQuantile(0.975);
  // Far beyond its bound, an estimate's upper end grows with the square of the quantile.
  const double above = at_bound ? wider * wider : wider;
  return {value,
          standard_error,
          std::max(least, value - wider * (value - low)),
          value + above * (high - value),
          least,
          at_bound};
}

Estimate ModelFit::Of(double value, const Eigen::VectorXd& gradient) const {
  const double variance = gradient.dot(covariance * gradient);
  const double error = std::sqrt(std::max(0.0, variance));
  const double degrees = effective_samples - static_cast<double>(parameters.size());
  const double quantile = math::StudentQuantile(0.975, std::max(kLeastDegrees, degrees));
  return {value, error, value - quantile * error, value + quantile * error};
}

Estimate ModelFit::Of(std::size_t index, double scale) const {
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(parameters.size()));
  gradient(static_cast<Eigen::Index>(index)) = scale;
  return Of(scale * parameters.at(index), gradient);
}

ModelFit FitModel(const SampleModel& model, std::span<const double> x, std::span<const double> y,
                  std::vector<double> start, bool robust) {
  ACUS_ASSERT(x.size() == y.size());
  ModelFit fit;
  fit.parameters = std::move(start);
  const auto n = static_cast<int>(fit.parameters.size());
  fit.covariance = Eigen::MatrixXd::Zero(n, n);
  if (x.size() < 2 * fit.parameters.size()) {
    fit.message = "too few samples";
    return fit;
  }
  std::vector<double> weight(x.size(), 1.0);
  const SampleCost cost(model, x, y, weight, n);
  ceres::Solver::Summary summary = Solve(cost, fit.parameters);
  // Huber by reweighting, with the residuals' own robust scale.
  for (int round = 0; robust && round < 20; ++round) {
    const std::vector<double> residual = Residuals(model, x, y, fit.parameters);
    const double limit = kHuberDeviations * math::RobustDeviation(residual);
    if (!(limit > 0.0)) break;
    double largest_change = 0.0;
    for (std::size_t i = 0; i < weight.size(); ++i) {
      const double next = limit / std::max(limit, std::abs(residual[i]));
      largest_change = std::max(largest_change, std::abs(next - weight[i]));
      weight[i] = next;
    }
    if (largest_change < 1e-3) break;
    summary = Solve(cost, fit.parameters);
  }
  fit.converged = summary.IsSolutionUsable() && summary.termination_type == ceres::CONVERGENCE;
  fit.message = summary.message;
  const std::vector<double> residual = Residuals(model, x, y, fit.parameters);
  fit.rms_n = math::RootMeanSquare(residual);
  AddCovariance(model, x, weight, residual, fit);
  return fit;
}

}  // namespace acus::fitting
