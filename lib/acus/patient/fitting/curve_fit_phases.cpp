#include "acus/patient/fitting/curve_fit_phases.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "acus/base/math/statistics.h"

namespace acus::fitting {
namespace {

constexpr double kShortestPhaseMm = 3.0;  // A line over less depth has no slope to fit.
constexpr double kReversalMm = 3.0;       // Travel in which friction has turned round, at least...
constexpr double kReversalShare = 0.2;    // ...or this share of the withdrawal.
constexpr double kShortestHoldS = 1.0;
constexpr double kHoldForceS = 0.02;   // A hold begins with the mean force of this.
constexpr double kEntryShare = 0.5;    // Of the largest fall, that the entry's has at least.
constexpr double kRelaxationS = 10.0;  // One exponential describes so long a hold, not minutes.

/// Zero, with the offset's uncertainty times `factor`.
Estimate OffsetError(const PunctureCurveFit& fit, double factor) {
  if (!fit.offset_n) return {};
  const double half = factor * (fit.offset_n->high - fit.offset_n->value);
  return {0.0, factor * fit.offset_n->standard_error, -half, half};
}

}  // namespace

double OffsetN(const PunctureCurveFit& fit) {
  return fit.offset_n ? fit.offset_n->value : 0.0;
}

double FirstForceMm(const ForceCurve& curve, const PunctureCurveFit& fit) {
  const CurvePhases& phases = fit.phases;
  for (std::size_t i = phases.advance.begin; i < phases.advance.end; ++i) {
    if (phases.smooth_n[i] > OffsetN(fit) + phases.least_drop_n) return curve.depth_mm[i];
  }
  return curve.depth_mm[phases.advance.begin];
}

bool SignIsReversed(const ForceCurve& curve, const PunctureCurveFit& fit) {
  const CurvePhases& phases = fit.phases;
  const auto mean = [&](std::size_t begin, std::size_t end) {
    return math::Mean(std::span(curve.force_n).subspan(begin, end - begin));
  };
  if (phases.advance.size() < 10) return false;
  const double deep_n = mean(phases.advance.begin + phases.advance.size() / 2, phases.advance.end);
  const double clear_n = std::max(phases.least_drop_n, 5.0 * phases.noise_n);
  if (phases.retract.size() >= 20) {
    return deep_n < mean(phases.retract.begin, phases.retract.end) - clear_n;
  }
  if (fit.offset_n) return deep_n < fit.offset_n->low - clear_n;
  // Neither rest nor retraction: the force only falls below that of the beginning.
  const double begin_n =
      mean(phases.advance.begin,
           phases.advance.begin + std::max<std::size_t>(phases.advance.size() / 20, 3));
  const auto advance =
      std::span(phases.smooth_n).subspan(phases.advance.begin, phases.advance.size());
  return deep_n < begin_n - clear_n && std::ranges::max(advance) < begin_n + clear_n;
}

Samples RestSamples(const ForceCurve& curve, const CurvePhases& phases) {
  Samples rest;
  for (std::size_t i = phases.rest.begin; i < phases.rest.end; ++i) {
    rest.Add(i, curve.depth_mm[i], curve.force_n[i]);
  }
  return rest;
}

void Draw(const ModelFit& law, const SampleModel& model, const Samples& samples,
          PunctureCurveFit& fit) {
  std::vector<double> gradient(law.parameters.size());
  for (std::size_t i = 0; i < samples.x.size(); ++i) {
    fit.model_n[samples.index[i]] = model(law.parameters, samples.x[i], gradient);
  }
}

namespace {

constexpr double kShortestApproachMm = 1.5;  // Less at one level may be anything.
constexpr std::size_t kFewestOfApproach = 20;

/// The samples before the force first leaves its level, if the drive moves from the first sample on
/// and the level does not depend on the depth: the needle is in air, and the level is the sensor's
/// zero. In tissue the force would rise with the buried shaft. Empty if there is no such approach.
Samples ApproachSamples(const ForceCurve& curve, const CurvePhases& phases) {
  Samples level;
  if (phases.advance.size() < kFewestOfApproach) return level;
  const auto first = std::span(phases.smooth_n).subspan(phases.advance.begin, kFewestOfApproach);
  const double level_n = math::Median(std::vector<double>(first.begin(), first.end()));
  std::size_t end = phases.advance.begin;
  while (end < phases.advance.end &&
         std::abs(phases.smooth_n[end] - level_n) < phases.least_drop_n) {
    level.Add(end, curve.depth_mm[end], curve.force_n[end]);
    ++end;
  }
  const bool then_rises = end < phases.advance.end && phases.smooth_n[end] > level_n;
  if (!then_rises || level.x.size() < kFewestOfApproach || level.Span() < kShortestApproachMm) {
    return {};
  }
  // The rise begins before it is clear of the noise.
  Samples before;
  const double last_mm = level.x.front() + 0.7 * level.Span();
  for (std::size_t i = 0; i < level.x.size() && level.x[i] <= last_mm; ++i) {
    before.Add(level.index[i], level.x[i], level.y[i]);
  }
  const ModelFit line = FitLine(before, math::Mean(before.x));
  const Estimate slope = line.Of(1);
  return line.converged && slope.low <= 0.0 && slope.high >= 0.0 ? before : Samples();
}

}  // namespace

void FitOffset(const ForceCurve& curve, PunctureCurveFit& fit) {
  Samples rest = RestSamples(curve, fit.phases);
  if (rest.x.size() < 10) rest = ApproachSamples(curve, fit.phases);
  const SampleModel constant = [](std::span<const double> p, double, std::span<double> gradient) {
    gradient[0] = 1.0;
    return p[0];
  };
  if (rest.x.size() < 10) return;
  const ModelFit level = FitModel(constant, rest.x, rest.y, {math::Median(rest.y)}, true);
  if (level.converged) fit.offset_n = level.Of(0);
}

void FitAdvance(const ForceCurve& curve, PunctureCurveFit& fit) {
  const CurvePhases& phases = fit.phases;
  Samples all;
  const double begin_mm = curve.depth_mm[phases.advance.begin];
  double early_n[2] = {0.0, 0.0};
  for (std::size_t i = phases.advance.begin; i < phases.advance.end; ++i) {
    const double travel_mm = curve.depth_mm[i] - begin_mm;
    if (travel_mm < kStickMm) early_n[0] = phases.smooth_n[i] - OffsetN(fit);
    if (travel_mm < 2.0 * kStickMm) early_n[1] = phases.smooth_n[i] - OffsetN(fit);
    if (phases.moving_in[i] && travel_mm > kStickMm)
      all.Add(i, curve.depth_mm[i], curve.force_n[i]);
  }
  if (all.Span() < 2.0 * kStickMm) return;
  // A needle that comes from outside begins with a puncture; one that is inside may soon meet
  // something small.
  double largest_n = 0.0;
  for (const PunctureEvent& event : phases.punctures) largest_n = std::max(largest_n, event.drop_n);
  const bool early_peak = std::ranges::any_of(phases.punctures, [&](const PunctureEvent& event) {
    return curve.depth_mm[event.peak] - begin_mm < 2.0 * kStickMm &&
           event.drop_n >= kEntryShare * largest_n;
  });
  fit.starts_in_tissue = !early_peak && early_n[0] > phases.least_drop_n &&
                         early_n[0] > 2.0 * (early_n[1] - early_n[0]);
  const double middle_mm = math::Mean(all.x);
  const ModelFit line = FitLine(all, middle_mm);
  if (!line.converged || !fit.starts_in_tissue) return;
  fit.advance_slope_n_per_mm = line.Of(1);
  fit.advance_travel_mm = std::ranges::max(curve.depth_mm) - begin_mm;
  fit.advance_tip_n =
      line.parameters[0] + line.parameters[1] * (begin_mm - middle_mm) - OffsetN(fit);
}

void FitRetraction(const ForceCurve& curve, PunctureCurveFit& fit) {
  const SampleRange range = fit.phases.retract;
  if (range.size() < 20) return;
  const double deepest_mm = curve.depth_mm[range.begin];
  const double least_mm = curve.depth_mm[range.end - 1];
  const double turned_mm =
      deepest_mm - std::max(kReversalMm, kReversalShare * (deepest_mm - least_mm));
  const double surface_mm = fit.starts_in_tissue ? least_mm + kStickMm : FirstForceMm(curve, fit);
  Samples samples;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const double depth_mm = curve.depth_mm[i];
    if (depth_mm < turned_mm && depth_mm > surface_mm) samples.Add(i, depth_mm, curve.force_n[i]);
  }
  if (samples.Span() < kShortestPhaseMm) return;
  const double middle_mm = math::Mean(samples.x);
  const ModelFit line = FitLine(samples, middle_mm);
  fit.friction_rms_n = line.rms_n;
  if (!line.converged) return;
  fit.friction_n_per_mm = line.Of(1, -1.0).AtLeast(0.0);
  const double outside_mm = fit.starts_in_tissue ? least_mm : surface_mm;
  fit.withdrawal_tip_n =
      OffsetN(fit) - line.parameters[0] - line.parameters[1] * (outside_mm - middle_mm);
  Draw(line, Line(middle_mm), samples, fit);
}

void FitHold(const ForceCurve& curve, PunctureCurveFit& fit) {
  const CurvePhases& phases = fit.phases;
  SampleRange range = phases.hold;
  std::vector<double> first_n;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    if (curve.time_s[i] - curve.time_s[range.begin] < kHoldForceS) {
      first_n.push_back(curve.force_n[i] - OffsetN(fit));
    }
  }
  if (!first_n.empty()) fit.hold_begin_n = math::Mean(first_n);
  while (range.size() > 20 &&
         curve.time_s[range.end - 1] - curve.time_s[range.begin] > kRelaxationS) {
    --range.end;
  }
  if (range.size() < 20 ||
      curve.time_s[range.end - 1] - curve.time_s[range.begin] < kShortestHoldS) {
    return;
  }
  // The drive stopped where its straight advance meets the greatest depth.
  const std::size_t last = phases.advance.end - 1;
  std::size_t moving = last;
  while (moving > phases.advance.begin && !phases.moving_in[moving]) --moving;
  const double hold_mm = curve.depth_mm[range.begin + range.size() / 2];
  const double start_s = std::clamp(
      curve.time_s[moving] + (hold_mm - curve.depth_mm[moving]) / phases.advance_mm_per_s,
      curve.time_s[moving], curve.time_s[range.begin]);
  Samples samples;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    samples.Add(i, curve.time_s[i], curve.force_n[i]);
  }
  const double end_n = math::Median(std::span(samples.y).last(samples.y.size() / 4));
  const double begin_n = math::Median(std::span(samples.y).first(samples.y.size() / 50 + 3));
  const double third_n = end_n + (begin_n - end_n) / std::exp(1.0);
  double tau_s = 0.2 * (samples.x.back() - start_s);
  for (std::size_t i = range.begin; i < range.end; ++i) {
    if ((phases.smooth_n[i] - third_n) * (begin_n - end_n) > 0.0) continue;
    tau_s = std::max(0.02, curve.time_s[i] - start_s);
    break;
  }
  const SampleModel model = Relaxation(start_s);
  const ModelFit decay =
      FitModel(model, samples.x, samples.y, {end_n, begin_n - end_n, std::log(tau_s)}, true);
  fit.relaxation_rms_n = decay.rms_n;
  if (!decay.converged) return;
  const double tau = std::exp(decay.parameters[2]);
  const double base_n = decay.parameters[0] - OffsetN(fit);
  const double total_n = base_n + decay.parameters[1];
  if (!(std::abs(total_n) > 1e-9) || tau > 3.0 * (samples.x.back() - start_s)) return;
  Eigen::VectorXd gradient(3);
  gradient << -decay.parameters[1] / (total_n * total_n), base_n / (total_n * total_n), 0.0;
  const double from_offset = std::abs(decay.parameters[1]) / (total_n * total_n);
  fit.relaxation_fraction =
      Difference(decay.Of(decay.parameters[1] / total_n, gradient), OffsetError(fit, from_offset))
          .AtLeast(0.0);
  // Its logarithm is fitted: both ends are above 0.
  const Estimate log_tau = decay.Of(2);
  fit.relaxation_time_s = {tau, tau * log_tau.standard_error, std::exp(log_tau.low),
                           std::exp(log_tau.high), 0.0};
  Draw(decay, model, samples, fit);
}

}  // namespace acus::fitting
