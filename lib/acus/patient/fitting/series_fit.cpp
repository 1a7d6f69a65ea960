#include "acus/patient/fitting/series_fit.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <ceres/ceres.h>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::fitting {
namespace {

constexpr double kHuberKneeDeviations = 2.5;
constexpr double kRelativeStep = 1e-5;  // Of the allowed range or the value: central differences.
constexpr double kNullSpace = 1e-9;  // Smaller eigenvalues of the scaled normal matrix: rounding.

/// Everything that one evaluation needs; the free parameters are those whose bounds differ.
class SeriesCost : public ceres::CostFunction {
 public:
  SeriesCost(const SeriesModel& model, std::span<const double> y,
             const std::vector<SeriesParameter>& parameters, const std::vector<double>& weight)
      : model_(model), y_(y), weight_(weight) {
    for (const SeriesParameter& parameter : parameters) all_.push_back(parameter.start);
    for (std::size_t i = 0; i < parameters.size(); ++i) {
      const SeriesParameter& p = parameters[i];
      if (p.low == p.high) continue;
      free_.push_back(i);
      low_.push_back(p.low);
      high_.push_back(p.high);
      step_.push_back(kRelativeStep *
                      std::max(std::abs(p.start), std::min(1.0, 0.1 * (p.high - p.low))));
    }
    set_num_residuals(static_cast<int>(y.size()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(free_.size()));
  }

  const std::vector<std::size_t>& free() const { return free_; }
  double low(std::size_t k) const { return low_[k]; }
  double high(std::size_t k) const { return high_[k]; }

  /// sqrt(weight) (model - y).
  bool Residuals(std::span<const double> free, std::vector<double>& residual) const {
    std::vector<double> parameters = all_;
    for (std::size_t k = 0; k < free_.size(); ++k) parameters[free_[k]] = free[k];
    residual.resize(y_.size());
    model_(parameters, residual);
    bool finite = true;
    for (std::size_t i = 0; i < residual.size(); ++i) {
      residual[i] = std::sqrt(weight_[i]) * (residual[i] - y_[i]);
      finite = finite && std::isfinite(residual[i]);
    }
    return finite;
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    const std::span<const double> here(parameters[0], free_.size());
    const bool known = last_.is_finite && std::ranges::equal(here, last_.at);
    if (!known) {
      last_.at.assign(here.begin(), here.end());
      last_.jacobian.clear();
      last_.is_finite = Residuals(here, last_.residual);
    }
    if (!last_.is_finite) return false;
    std::ranges::copy(last_.residual, residuals);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    if (last_.jacobian.empty() && !Differences(here, last_.jacobian)) return false;
    std::ranges::copy(last_.jacobian, jacobians[0]);
    return true;
  }

 private:
  /// The solver requests one point up to three times: in a line search, as a candidate, and once it
  /// is accepted.
  struct Point {
    std::vector<double> at;
    std::vector<double> residual;
    std::vector<double> jacobian;  ///< Row by row; empty until it is requested.
    bool is_finite = false;
  };

  /// False, and `jacobian` empty, if the model gives no numbers near `here`.
  bool Differences(std::span<const double> here, std::vector<double>& jacobian) const {
    std::vector<double> moved(here.begin(), here.end());
    std::vector<double> up;
    std::vector<double> down;
    std::vector<double> differences(y_.size() * free_.size());
    for (std::size_t k = 0; k < free_.size(); ++k) {
      const double above = std::min(here[k] + step_[k], high_[k]);
      const double below = std::max(here[k] - step_[k], low_[k]);
      moved[k] = above;
      if (!Residuals(moved, up)) return false;
      moved[k] = below;
      if (!Residuals(moved, down)) return false;
      moved[k] = here[k];
      for (std::size_t i = 0; i < up.size(); ++i) {
        differences[i * free_.size() + k] = (up[i] - down[i]) / (above - below);
      }
    }
    jacobian = std::move(differences);
    return true;
  }

  const SeriesModel& model_;
  std::span<const double> y_;
  const std::vector<double>& weight_;
  std::vector<double> all_;
  std::vector<std::size_t> free_;
  std::vector<double> low_;
  std::vector<double> high_;
  std::vector<double> step_;
  mutable Point last_;
};

bool Solve(const SeriesCost& cost, int most_iterations, std::vector<double>& free) {
  ceres::Problem::Options ownership;
  ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  problem.AddResidualBlock(const_cast<SeriesCost*>(&cost), nullptr, free.data());
  for (std::size_t k = 0; k < free.size(); ++k) {
    problem.SetParameterLowerBound(free.data(), static_cast<int>(k), cost.low(k));
    problem.SetParameterUpperBound(free.data(), static_cast<int>(k), cost.high(k));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.num_threads = 1;  // More threads would sum in another order: other last bits.
  options.max_num_iterations = most_iterations;
  options.function_tolerance = 1e-9;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.IsSolutionUsable();
}

/// Covariance of the free parameters and which directions the samples do not see.
void AddCovariance(const SeriesCost& cost, const std::vector<double>& free,
                   const std::vector<double>& residual, bool weight_is_information,
                   SeriesFit& fit) {
  const auto n = static_cast<Eigen::Index>(free.size());
  const auto rows = static_cast<Eigen::Index>(residual.size());
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> jacobian(rows, n);
  std::vector<double> again(residual.size());
  const double* parameter = free.data();
  double* into = jacobian.data();
  const bool finite = cost.Evaluate(&parameter, again.data(), &into);
  double squares = 0.0;
  for (const double r : residual) squares += r * r;
  fit.inflation = Inflation(residual);
  fit.effective_samples = std::max(1.0, static_cast<double>(rows) / fit.inflation);
  const double degrees = std::max(1.0, static_cast<double>(rows - n));
  Eigen::VectorXd scale(n);
  for (Eigen::Index k = 0; k < n; ++k) scale(k) = jacobian.col(k).norm();
  const double largest = finite && n > 0 ? scale.maxCoeff() : 0.0;
  for (Eigen::Index k = 0; k < n; ++k) scale(k) = scale(k) > 0.0 ? 1.0 / scale(k) : 0.0;
  const Eigen::MatrixXd scaled = jacobian * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled.transpose() * scaled);
  Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd unseen = Eigen::VectorXd::Zero(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd direction = eigen.eigenvectors().col(k);
    if (eigen.eigenvalues()(k) > kNullSpace) {
      inverse += direction * direction.transpose() / eigen.eigenvalues()(k);
    } else {
      unseen += direction.cwiseAbs2();
    }
  }
  inverse = scale.asDiagonal() * inverse * scale.asDiagonal();
  if (!weight_is_information) inverse *= squares / degrees * fit.inflation;
  for (Eigen::Index a = 0; a < n; ++a) {
    const std::size_t i = cost.free()[static_cast<std::size_t>(a)];
    const SeriesParameter& p = fit.definition[i];
    for (Eigen::Index b = 0; b < n; ++b) {
      fit.covariance(static_cast<Eigen::Index>(i),
                     static_cast<Eigen::Index>(cost.free()[static_cast<std::size_t>(b)])) =
          inverse(a, b);
    }
    const double half = 2.0 * std::sqrt(std::max(0.0, inverse(a, a)));
    fit.undetermined[i] =
        !(largest > 0.0) || scale(a) == 0.0 || unseen(a) > 0.01 || half > 0.5 * (p.high - p.low);
    const double value = fit.parameters[i];
    const double near = 1e-6 * (p.high - p.low);
    fit.at_bound[i] = value <= p.low + near || value >= p.high - near;
  }
  const double m = fit.effective_samples;
  fit.aic = m * std::log(std::max(squares, 1e-30) / static_cast<double>(rows)) +
            2.0 * static_cast<double>(n + 1);
}

}  // namespace

Estimate SeriesFit::Bounded(std::size_t index) const {
  const SeriesParameter& p = definition[index];
  Estimate estimate = Of(index);
  if (undetermined[index]) return {estimate.value, p.high - p.low, p.low, p.high};
  estimate.low = std::clamp(estimate.low, p.low, estimate.value);
  estimate.high = std::clamp(estimate.high, estimate.value, p.high);
  return estimate;
}

SeriesFit FitSeries(const SeriesModel& model, std::span<const double> y,
                    std::vector<SeriesParameter> parameters, const SeriesOptions& options) {
  SeriesFit fit;
  for (const SeriesParameter& p : parameters) {
    ACUS_ASSERT(p.low <= p.start && p.start <= p.high);
    fit.parameters.push_back(p.start);
  }
  fit.definition = std::move(parameters);
  const auto n = static_cast<Eigen::Index>(fit.parameters.size());
  fit.covariance = Eigen::MatrixXd::Zero(n, n);
  fit.undetermined.assign(fit.parameters.size(), true);
  fit.at_bound.assign(fit.parameters.size(), false);
  std::vector<double> weight = options.weight;
  if (weight.empty()) weight.assign(y.size(), 1.0);
  ACUS_ASSERT(weight.size() == y.size());
  const std::vector<double> given = weight;
  const SeriesCost cost(model, y, fit.definition, weight);
  std::vector<double> free;
  for (const std::size_t i : cost.free()) free.push_back(fit.parameters[i]);
  if (y.size() < 2 * free.size() || free.empty()) {
    fit.message = free.empty() ? "nothing to fit" : "too few samples";
    return fit;
  }
  std::vector<double> residual;
  if (!cost.Residuals(free, residual)) {
    fit.message = "the model is not finite where the fit starts";
    return fit;
  }
  fit.converged = Solve(cost, options.most_iterations, free);
  for (int round = 0; options.robust && round < 8; ++round) {
    weight = given;
    if (!cost.Residuals(free, residual)) break;
    const double limit = kHuberKneeDeviations * math::RobustDeviation(residual);
    if (!(limit > 0.0)) break;
    for (std::size_t i = 0; i < weight.size(); ++i) {
      weight[i] *= limit / std::max(limit, std::abs(residual[i]));
    }
    fit.converged = Solve(cost, options.most_iterations, free);
  }
  fit.converged = cost.Residuals(free, residual) && fit.converged;
  for (std::size_t k = 0; k < free.size(); ++k) fit.parameters[cost.free()[k]] = free[k];
  std::vector<double> plain(y.size());
  model(fit.parameters, plain);
  for (std::size_t i = 0; i < plain.size(); ++i) plain[i] -= y[i];
  fit.rms_n = math::RootMeanSquare(plain);
  if (fit.converged) AddCovariance(cost, free, residual, options.weight_is_information, fit);
  if (!fit.converged) fit.message = "the solver did not converge";
  return fit;
}

}  // namespace acus::fitting
