#include "acus/patient/fitting/fitted_relaxation.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/series_fit.h"

namespace acus::fitting {
namespace {

using forces::ForceRelaxation;
using nlohmann::json;

constexpr double kFirstHoldS = 0.02;  // A hold begins with the mean of this.
constexpr double kShortestMeanHoldS = 1.0;
constexpr double kTimesPerDecade = 20.0;
constexpr double kLeastTermShare = 0.005;  // Less is not worth a term.
constexpr double kMostTermShares = 0.95;   // Of a table.
constexpr double kShortestTermS = 0.02;
constexpr double kLongestTermS = 1e4;

double MeanForceN(const ForceCurve& curve, const PunctureCurveFit& fit, double from_s,
                  double to_s) {
  const double begin_s = curve.time_s[fit.phases.hold.begin];
  double sum_n = 0.0;
  double count = 0.0;
  for (std::size_t i = fit.phases.hold.begin; i < fit.phases.hold.end; ++i) {
    const double held_s = curve.time_s[i] - begin_s;
    if (held_s < from_s || held_s >= to_s) continue;
    sum_n += curve.force_n[i];
    count += 1.0;
  }
  return count > 0.0 ? sum_n / count - (fit.offset_n ? fit.offset_n->value : 0.0) : NAN;
}

/// Shares of what the terms before leave, and logarithms of times and of their ratios.
ForceRelaxation TermsOf(std::span<const double> p) {
  ForceRelaxation terms;
  double left = 1.0;
  double time_s = 1.0;
  terms.num_terms = static_cast<int>(p.size()) / 2;
  for (int k = 0; k < terms.num_terms; ++k) {
    terms.share[k] = p[2 * k] * left;
    left -= terms.share[k];
    time_s *= std::exp(p[2 * k + 1]);
    terms.time_s[k] = time_s;
  }
  return terms;
}

SeriesFit FitTerms(const HoldCurve& curve, int num_terms) {
  const SeriesModel model = [&](std::span<const double> p, std::span<double> predicted) {
    const ForceRelaxation terms = TermsOf(p);
    for (std::size_t i = 0; i < predicted.size(); ++i) {
      predicted[i] = 1.0;
      for (int k = 0; k < terms.num_terms; ++k) {
        predicted[i] += terms.share[k] * std::expm1(-curve.held_s[i] / terms.time_s[k]);
      }
    }
  };
  std::vector<SeriesParameter> parameters;
  for (int k = 0; k < num_terms; ++k) {
    parameters.push_back({"share", 0.3, 0.0, 0.97});
    if (k == 0) {
      const double start_s = num_terms == 1 ? 1.0 : 0.3;
      parameters.push_back(
          {"time", std::log(start_s), std::log(kShortestTermS), std::log(kLongestTermS)});
    } else {
      parameters.push_back({"ratio", std::log(8.0), std::log(2.0), std::log(300.0)});
    }
  }
  return FitSeries(model, curve.left, parameters, {.most_iterations = 200});
}

/// Four digits: more is not known, and is hard to read.
double Rounded(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 3.0);
  return std::round(value / unit) * unit;
}

}  // namespace

HoldCurve HoldCurve::MeanOf(std::span<const ForceCurve* const> curves,
                            std::span<const PunctureCurveFit> fits) {
  std::vector<double> lasts_s;
  std::vector<std::size_t> held;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const SampleRange& hold = fits[i].phases.hold;
    if (hold.size() < 20) continue;
    const double last_s = curves[i]->time_s[hold.end - 1] - curves[i]->time_s[hold.begin];
    if (last_s < kShortestMeanHoldS || !(MeanForceN(*curves[i], fits[i], 0.0, kFirstHoldS) > 0.0))
      continue;
    lasts_s.push_back(last_s);
    held.push_back(i);
  }
  HoldCurve mean;
  if (held.empty()) return mean;
  const double end_s = math::Median(lasts_s);
  const double step = std::pow(10.0, 1.0 / kTimesPerDecade);
  for (double from_s = kFirstHoldS; from_s * step < end_s; from_s *= step) {
    double sum = 0.0;
    double count = 0.0;
    for (const std::size_t i : held) {
      const double left = MeanForceN(*curves[i], fits[i], from_s, from_s * step) /
                          MeanForceN(*curves[i], fits[i], 0.0, kFirstHoldS);
      if (std::isnan(left)) continue;
      sum += left;
      count += 1.0;
    }
    if (count == 0.0) continue;
    mean.held_s.push_back(from_s * std::sqrt(step));
    mean.left.push_back(sum / count);
  }
  return mean;
}

ForceRelaxation FitHold(const HoldCurve& curve) {
  SeriesFit best;
  for (int num_terms = 1; num_terms <= ForceRelaxation::kMostTerms; ++num_terms) {
    if (curve.left.size() < 8 * static_cast<std::size_t>(num_terms)) break;
    SeriesFit fit = FitTerms(curve, num_terms);
    if (fit.converged && (!best.converged || fit.aic < best.aic)) best = std::move(fit);
  }
  return best.converged ? TermsOf(best.parameters) : ForceRelaxation{};
}

json RelaxationRow(const ForceRelaxation& hold) {
  const double relaxing = 1.0 - hold.ElasticShare();
  const double scale = std::min(1.0, kMostTermShares / std::max(relaxing, 1e-12));
  json terms = json::array();
  for (int k = 0; k < hold.num_terms; ++k) {
    const double share = hold.share[k] * scale;
    if (share < kLeastTermShare) continue;
    const double time_s = std::clamp(hold.time_s[k], kShortestTermS, kLongestTermS);
    terms.push_back({{"share", std::floor(share * 1e4) / 1e4}, {"time_s", Rounded(time_s)}});
  }
  return terms;
}

}  // namespace acus::fitting
