// Fits of models that run through a whole recording: replays of states, not functions of one
// sample.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "acus/patient/fitting/least_squares.h"

namespace acus::fitting {

/// Fills `predicted`, as long as the measured samples, for these parameters.
using SeriesModel =
    std::function<void(std::span<const double> parameters, std::span<double> predicted)>;

struct SeriesParameter {
  std::string name;
  double start = 0.0;
  double low = 0.0;   ///< Allowed from here...
  double high = 0.0;  ///< ...to here; low == high holds the parameter.
};

struct SeriesOptions {
  bool robust = false;                 ///< Huber at 2.5 robust standard deviations, by reweighting.
  std::vector<double> weight = {};     ///< By sample, >= 0; empty: 1 each.
  bool weight_is_information = false;  ///< The weights are 1 / variance of each sample, correlation
                                       ///< included: the covariance follows from them alone.
  int most_iterations = 60;
};

/// As ModelFit, with what the samples do not say: a parameter is undetermined if the samples change
/// less than rounding when it does, or if its 95 % interval is wider than what is allowed. Its
/// interval is then all that is allowed.
struct SeriesFit : ModelFit {
  std::vector<SeriesParameter> definition;
  std::vector<bool> undetermined;  ///< By parameter; held ones are.
  std::vector<bool> at_bound;      ///< Free, but ended at an end of what is allowed.
  double aic = 0.0;                ///< With the number of independent samples; for one data set.

  Estimate Bounded(std::size_t index) const;  ///< Of(index), within what is allowed.
};

/// Least squares by Ceres (one thread) with central differences, inside the bounds. Deterministic.
/// @pre all starts are within their bounds; y as long as the model's prediction.
SeriesFit FitSeries(const SeriesModel& model, std::span<const double> y,
                    std::vector<SeriesParameter> parameters, const SeriesOptions& options = {});

}  // namespace acus::fitting
