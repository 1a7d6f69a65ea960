// Fits of a few parameters to many samples, with intervals that do not assume white noise.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

namespace acus::fitting {

/// One fitted number. The interval is for this number alone; AmongSeveral gives the wider one that
/// holds for several numbers at once.
struct Estimate {
  double value = 0.0;
  double standard_error = 0.0;
  double low = 0.0;  ///< 95 % interval.
  double high = 0.0;
  double least = -std::numeric_limits<double>::infinity();  ///< It cannot be below.
  bool at_bound = false;  ///< The data alone would place it below `least`.

  /// The 95 % interval of a normal variable.
  static Estimate Normal(double value, double standard_error);

  /// The estimate of a quantity that cannot be below `bound`: where the data would place it below,
  /// the bound, with the one-sided interval of the profile likelihood. With the free value v and
  /// half width h, all truths t >= bound with (v - t)^2 - (v - bound)^2 <= h^2, that is up to
  /// v + hypot(bound - v, h). It holds the truth at least as often as the free interval, because
  /// the left side is at most (v - t)^2, and it is never empty.
  Estimate AtLeast(double bound) const;

  bool Contains(double truth) const { return low <= truth && truth <= high; }
  /// The interval such that k of them hold all at once with 95 % (Bonferroni).
  Estimate AmongSeveral(int num_intervals) const;
};

/// {"value", "standard_error", "low_95", "high_95"}, and "at_bound": true where it is.
nlohmann::json EstimateJson(const Estimate& estimate);

/// value and d(value)/d(parameters) at x. @param gradient  as long as the parameters.
using SampleModel =
    std::function<double(std::span<const double> parameters, double x, std::span<double> gradient)>;

struct ModelFit {
  bool converged = false;
  std::string message;  ///< The solver's own words.
  std::vector<double> parameters;
  Eigen::MatrixXd covariance;  ///< Of the parameters, autocorrelation included.
  double rms_n = 0.0;          ///< Of all residuals.
  double inflation = 1.0;      ///< Samples per independent sample, >= 1.
  double effective_samples = 0.0;

  /// @param index  of a parameter. @param scale  multiplies it, for a change of unit or sign.
  Estimate Of(std::size_t index, double scale = 1.0) const;
  /// A function of the parameters with this value and gradient (delta method).
  Estimate Of(double value, const Eigen::VectorXd& gradient) const;
};

/// Least squares (Ceres, one thread), from `start`. With `robust`, residuals beyond 2.5 robust
/// standard deviations count linearly (Huber).
///
/// Covariance: s^2 (J^T W J)^-1 times the inflation 1 + 2 (rho_1 + rho_2 + ...), the residuals'
/// autocorrelations summed up to the first that is not positive: what n correlated samples are
/// worth. White noise gives an inflation near 1.
/// @pre x and y have the same length. Fewer samples than twice the parameters: not converged.
ModelFit FitModel(const SampleModel& model, std::span<const double> x, std::span<const double> y,
                  std::vector<double> start, bool robust);

/// Samples per independent one: 1 + 2 (rho_1 + ...), the autocorrelations summed up to the first
/// that is not positive or a quarter of the record; >= 1.
double Inflation(std::span<const double> residual);

}  // namespace acus::fitting
