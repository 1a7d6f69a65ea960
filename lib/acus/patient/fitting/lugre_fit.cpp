#include "acus/patient/fitting/lugre_fit.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/depth_bins.h"
#include "acus/patient/fitting/series_fit.h"

namespace acus::fitting {
namespace {

constexpr std::size_t kMostSamples = 4000;
constexpr double kLongestRestS = 0.3;
constexpr double kRestShare = 0.02;     // Slower than this share of the top speed: at rest.
constexpr double kOneSpeedRatio = 1.6;  // Fast over slow: less is one speed.

enum { kSigma0, kSigma1, kSigma2, kCoulomb, kStaticRatio, kStribeck, kGrowth, kOffset, kNum };
constexpr const char* kNames[kNum] = {"sigma0_n_per_mm", "sigma1_n_s_per_mm", "sigma2_n_s_per_mm",
                                      "coulomb_n",       "static_ratio",      "stribeck_mm_per_s",
                                      "growth_per_mm",   "offset_n"};

LuGreParameters FromVector(std::span<const double> p, double middle_mm) {
  const double coulomb = std::exp(p[kCoulomb]);
  return {.sigma0_n_per_mm = std::exp(p[kSigma0]),
          .sigma1_n_s_per_mm = p[kSigma1],
          .sigma2_n_s_per_mm = p[kSigma2],
          .coulomb_n = coulomb,
          .static_n = coulomb * std::exp(p[kStaticRatio]),
          .stribeck_mm_per_s = std::exp(p[kStribeck]),
          .growth_per_mm = p[kGrowth],
          .middle_mm = middle_mm,
          .offset_n = p[kOffset]};
}

/// What the motion is like.
struct Motion {
  double top_mm_per_s = 0.0;
  double slow_mm_per_s = 0.0;  ///< Exceeded in 95 % of the travel time.
  bool reverses = false;
  std::vector<double> weight;  ///< 0 in long rests.
};

Motion Describe(const forces::ForceCurve& curve) {
  Motion motion;
  std::vector<double> speed(curve.size(), 0.0);
  for (std::size_t i = 1; i < curve.size(); ++i) {
    speed[i] =
        (curve.depth_mm[i] - curve.depth_mm[i - 1]) / (curve.time_s[i] - curve.time_s[i - 1]);
  }
  std::vector<double> magnitude;
  for (const double v : speed) magnitude.push_back(std::abs(v));
  motion.top_mm_per_s = math::Quantile(magnitude, 0.98);
  const double rest = kRestShare * motion.top_mm_per_s;
  std::vector<double> moving;
  bool in = false;
  bool out = false;
  for (const double v : speed) {
    if (std::abs(v) > rest) moving.push_back(std::abs(v));
    in = in || v > rest;
    out = out || v < -rest;
  }
  motion.reverses = in && out;
  if (!moving.empty()) motion.slow_mm_per_s = math::Quantile(moving, 0.1);
  motion.weight.assign(curve.size(), 1.0);
  for (std::size_t i = 0; i < curve.size();) {
    std::size_t end = i;
    while (end < curve.size() && std::abs(speed[end]) <= rest) ++end;
    if (end > i && curve.time_s[end - 1] - curve.time_s[i] > kLongestRestS) {
      std::fill(motion.weight.begin() + static_cast<std::ptrdiff_t>(i),
                motion.weight.begin() + static_cast<std::ptrdiff_t>(end), 0.0);
    }
    i = end + 1;
  }
  return motion;
}

std::vector<SeriesParameter> Start(const Motion& motion, double force_n, double offset_n,
                                   double bristle_mm, double ratio, double stribeck_share) {
  const bool one_speed = motion.top_mm_per_s < kOneSpeedRatio * motion.slow_mm_per_s;
  const double coulomb = std::log(std::max(1e-3, force_n));
  const double stribeck = std::log(std::max(1e-3, stribeck_share * motion.top_mm_per_s));
  std::vector<SeriesParameter> p(kNum);
  p[kSigma0] = {kNames[kSigma0], coulomb - std::log(bristle_mm), std::log(1e-3), std::log(1e4)};
  p[kSigma1] = {kNames[kSigma1], 0.0, 0.0, 10.0};
  p[kSigma2] = {kNames[kSigma2], 0.0, 0.0, 10.0};
  p[kCoulomb] = {kNames[kCoulomb], coulomb, std::log(1e-4), std::log(200.0)};
  p[kStaticRatio] = {kNames[kStaticRatio], std::log(ratio), std::log(0.02), std::log(20.0)};
  p[kStribeck] = {kNames[kStribeck], stribeck, stribeck - std::log(300.0),
                  stribeck + std::log(30.0)};
  p[kGrowth] = {kNames[kGrowth], 0.0, -1.0, 1.0};
  p[kOffset] = {kNames[kOffset], offset_n, offset_n - 50.0, offset_n + 50.0};
  const auto hold = [&](int k, double at) {
    p[static_cast<std::size_t>(k)] = {kNames[k], at, at, at};
  };
  if (one_speed) {
    hold(kSigma2, 0.0);
    hold(kStaticRatio, 0.0);
    hold(kStribeck, 0.0);
  }
  if (!motion.reverses) hold(kOffset, offset_n);
  return p;
}

/// Logarithm of the static force: that of the Coulomb force and of the ratio to it, together.
Estimate LogStatic(const SeriesFit& fit) {
  const Estimate coulomb = fit.Bounded(kCoulomb), ratio = fit.Bounded(kStaticRatio);
  const double value = coulomb.value + ratio.value;
  if (fit.undetermined[kCoulomb] || fit.undetermined[kStaticRatio]) {
    return {value, std::hypot(coulomb.standard_error, ratio.standard_error),
            coulomb.low + ratio.low, coulomb.high + ratio.high};
  }
  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(kNum);
  gradient(kCoulomb) = gradient(kStaticRatio) = 1.0;
  return fit.Of(value, gradient);
}

void AddEstimates(const SeriesFit& fit, LuGreFit& result) {
  for (std::size_t k = 0; k < kNum; ++k) {
    if (fit.definition[k].low == fit.definition[k].high) continue;
    Estimate estimate = k == kStaticRatio ? LogStatic(fit) : fit.Bounded(k);
    const std::string name = k == kStaticRatio ? "static_n" : kNames[k];
    const bool logarithm = k == kSigma0 || k == kCoulomb || k == kStaticRatio || k == kStribeck;
    if (logarithm) {
      const double value = std::exp(estimate.value);
      estimate = {value, value * estimate.standard_error, std::exp(estimate.low),
                  std::exp(estimate.high)};
    }
    result.estimates.emplace_back(name, estimate);
    if (fit.undetermined[k]) {
      result.undetermined.push_back(name);
      result.warnings.push_back(name + ": the recording does not determine it");
    }
  }
}

}  // namespace

std::vector<double> ReplayLuGre(const LuGreParameters& p, std::span<const double> time_s,
                                std::span<const double> depth_mm) {
  ACUS_ASSERT(time_s.size() == depth_mm.size());
  std::vector<double> force(time_s.size(), p.offset_n);
  double z = 0.0;
  for (std::size_t i = 1; i < time_s.size(); ++i) {
    const double dt_s = time_s[i] - time_s[i - 1];
    const double travel_mm = depth_mm[i] - depth_mm[i - 1];
    const double speed = travel_mm / dt_s;
    const double g =
        p.coulomb_n + (p.static_n - p.coulomb_n) * std::exp(-std::abs(speed) / p.stribeck_mm_per_s);
    const double limit = travel_mm >= 0.0 ? g / p.sigma0_n_per_mm : -g / p.sigma0_n_per_mm;
    const double before = z;
    z = limit + (z - limit) * std::exp(-std::abs(travel_mm) * p.sigma0_n_per_mm / g);
    const double growth = 1.0 + p.growth_per_mm * (depth_mm[i] - p.middle_mm);
    force[i] += growth * (p.sigma0_n_per_mm * z + p.sigma1_n_s_per_mm * (z - before) / dt_s +
                          p.sigma2_n_s_per_mm * speed);
  }
  return force;
}

LuGreFit FitLuGre(const forces::ForceCurve& whole) {
  LuGreFit result;
  const double duration_s = whole.size() > 1 ? whole.time_s.back() - whole.time_s.front() : 0.0;
  const forces::ForceCurve curve =
      Thinned(whole, {0, whole.size()}, 0.99 * duration_s / static_cast<double>(kMostSamples));
  if (curve.size() < 40) {
    result.message = Message("LuGre: ", curve.size(), " samples are too few");
    return result;
  }
  const Motion motion = Describe(curve);
  if (!(motion.slow_mm_per_s > 0.0)) {
    result.message = "LuGre: the needle does not move";
    return result;
  }
  const auto [low, high] = std::ranges::minmax(curve.depth_mm);
  const double middle_mm = 0.5 * (low + high);
  const double offset_n = motion.reverses ? math::Median(curve.force_n) : 0.0;
  std::vector<double> size;
  for (const double f : curve.force_n) size.push_back(std::abs(f - offset_n));
  const double force_n = math::Median(size);
  const SeriesModel model = [&](std::span<const double> p, std::span<double> predicted) {
    const std::vector<double> force =
        ReplayLuGre(FromVector(p, middle_mm), curve.time_s, curve.depth_mm);
    std::ranges::copy(force, predicted.begin());
  };
  SeriesFit best;
  const bool one_speed = motion.top_mm_per_s < kOneSpeedRatio * motion.slow_mm_per_s;
  for (const double bristle_mm : {0.1, 1.0}) {
    for (const double ratio : {1.0, 1.6}) {
      for (const double share : {0.05, 0.3}) {
        if (one_speed && (ratio != 1.0 || share != 0.3)) continue;
        SeriesFit fit = FitSeries(model, curve.force_n,
                                  Start(motion, force_n, offset_n, bristle_mm, ratio, share),
                                  {.weight = motion.weight, .most_iterations = 60});
        if (fit.converged && (!best.converged || fit.aic < best.aic)) best = std::move(fit);
      }
    }
  }
  result.converged = best.converged;
  if (!best.converged) {
    result.message = "LuGre: the solver did not converge";
    return result;
  }
  result.parameters = FromVector(best.parameters, middle_mm);
  if (one_speed) {
    result.warnings.push_back(
        Message("sigma2, static_n, stribeck_mm_per_s: the needle moves at one speed only (",
                motion.slow_mm_per_s, " to ", motion.top_mm_per_s,
                " mm/s), which does not separate them from coulomb_n; held"));
    result.undetermined = {"sigma2_n_s_per_mm", "static_n", "stribeck_mm_per_s"};
  }
  if (!motion.reverses) {
    result.warnings.push_back("offset_n: the needle moves one way only; held at 0");
  }
  AddEstimates(best, result);
  double squares = 0.0;
  double count = 0.0;
  std::vector<double> predicted(curve.size());
  model(best.parameters, predicted);
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    squares += motion.weight[i] * std::pow(predicted[i] - curve.force_n[i], 2);
    count += motion.weight[i];
  }
  result.rms_n = std::sqrt(squares / std::max(1.0, count));
  result.aic = best.aic;
  return result;
}

}  // namespace acus::fitting
