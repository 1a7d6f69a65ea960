#include <cmath>

#include "acus/patient/fitting/depth_bins.h"
#include "acus/patient/fitting/fit_models.h"
#include "acus/patient/fitting/shared_fit.h"

namespace acus::fitting {
namespace {

using report::Plot;
using report::Series;
using report::Style;

/// Samples of `range`, y over x.
Series Part(const char* name, const std::vector<double>& x, const std::vector<double>& y,
            const SampleRange& range) {
  Series series{.name = name};
  for (std::size_t i = range.begin; i < range.end; ++i) {
    series.x.push_back(x[i]);
    series.y.push_back(y[i]);
  }
  return series;
}

/// The mechanical model with its events by sample of the recording, 0 where it does not reach.
std::vector<double> Replayed(const FittedCurve& fitted, const MechanicalModel& model) {
  std::vector<double> force(fitted.curve.size(), 0.0);
  const std::vector<double> part = ReplayPhases(model, fitted.curve, fitted.puncture.phases);
  std::copy(part.begin(), part.end(),
            force.begin() + static_cast<std::ptrdiff_t>(fitted.puncture.phases.advance.begin));
  return force;
}

Series Left(const char* name, const Series& model, const Series& measured) {
  Series left{.name = name, .x = model.x};
  for (std::size_t i = 0; i < model.y.size(); ++i) left.y.push_back(measured.y[i] - model.y[i]);
  return left;
}

bool HasMechanical(const FittedCurve& fitted) {
  return fitted.mechanical && fitted.mechanical->converged;
}

}  // namespace

std::vector<Plot> PuncturePlots(const FittedCurve& fitted, const std::vector<double>& x,
                                const char* x_label) {
  const ForceCurve& curve = fitted.curve;
  const PunctureCurveFit& fit = fitted.puncture;
  const Series measured{.name = "measured", .x = x, .y = curve.force_n};
  Series law{.name = "fit", .style = Style::kPoints};
  Series residual{.name = "measured - fit", .style = Style::kPoints};
  for (std::size_t i = 0; i < curve.size(); ++i) {
    if (!std::isfinite(fit.model_n[i])) continue;
    law.x.push_back(x[i]);
    law.y.push_back(fit.model_n[i]);
    residual.x.push_back(x[i]);
    residual.y.push_back(curve.force_n[i] - fit.model_n[i]);
  }
  Plot force{.title = curve.name, .x_label = x_label, .y_label = "force [N]"};
  force.series = {measured, law};
  for (const auto& event : fit.phases.punctures) force.marks.push_back({x[event.peak], ""});
  Plot rest{.x_label = x_label, .y_label = "residual [N]", .height_px = 180};
  rest.series = {residual};
  return {force, rest};
}

std::vector<Plot> DepthPlots(const FittedCurve& fitted) {
  const ForceCurve& curve = fitted.curve;
  const CurvePhases& phases = fitted.puncture.phases;
  Plot force{.title = curve.name + ": insertion and retraction",
             .x_label = "depth [mm]",
             .y_label = "force [N]"};
  Plot rest{.x_label = "depth [mm]", .y_label = "measured - model [N]", .height_px = 180};
  const Series in = Part("measured", curve.depth_mm, curve.force_n, phases.advance);
  force.series.push_back(in);
  Series out = Part("", curve.depth_mm, curve.force_n, phases.retract);
  if (fitted.gaussians && fitted.gaussians->converged) {
    Series sum{.name = std::to_string(fitted.gaussians->terms.size()) + " Gaussians", .x = in.x};
    for (const double depth : in.x) sum.y.push_back(SumN(fitted.gaussians->terms, depth));
    rest.series.push_back(Left("Gaussians", sum, in));
    force.series.push_back(std::move(sum));
  }
  if (HasMechanical(fitted)) {
    const std::vector<double> eventful = Replayed(fitted, fitted.mechanical->eventful);
    const std::vector<double> constant = Replayed(fitted, fitted.mechanical->constant);
    const Series model = Part("mechanical", curve.depth_mm, eventful, phases.advance);
    rest.series.push_back(Left("mechanical", model, in));
    force.series.push_back(model);
    force.series.push_back(
        Part("mechanical, two constants", curve.depth_mm, constant, phases.advance));
    if (!out.x.empty()) {
      const Series back = Part("", curve.depth_mm, eventful, phases.retract);
      Series left = Left("during withdrawal", back, out);
      rest.series.push_back(std::move(left));
      force.series.push_back(back);
      force.series.push_back(Part("", curve.depth_mm, constant, phases.retract));
    }
    for (const FoundPuncture& p : fitted.mechanical->punctures) {
      force.marks.push_back({p.law.contact_mm + p.law.puncture_mm, ""});
    }
  }
  if (!out.x.empty()) force.series.push_back(std::move(out));
  return {force, rest};
}

std::vector<Plot> TimePlots(const FittedCurve& fitted) {
  const ForceCurve& curve = fitted.curve;
  const CurvePhases& phases = fitted.puncture.phases;
  Plot force{.title = curve.name, .x_label = "time [s]", .y_label = "force [N]"};
  Plot rest{.x_label = "time [s]", .y_label = "measured - model [N]", .height_px = 180};
  const SampleRange moving{phases.advance.begin,
                           std::max(phases.retract.end, HoldRange(phases).end)};
  const Series measured = Part("measured", curve.time_s, curve.force_n, moving);
  force.series = {measured};
  if (HasMechanical(fitted)) {
    const Series model =
        Part("mechanical", curve.time_s, Replayed(fitted, fitted.mechanical->eventful), moving);
    rest.series.push_back(Left("mechanical", model, measured));
    force.series.push_back(model);
  }
  if (fitted.lugre && fitted.lugre->converged) {
    // An encoder's steps are leaps at 1 kHz; their mean is the motion.
    const ForceCurve thin = Thinned(curve, moving, 0.02);
    const Series model{.name = "LuGre",
                       .x = thin.time_s,
                       .y = ReplayLuGre(fitted.lugre->parameters, thin.time_s, thin.depth_mm)};
    rest.series.push_back(Left("LuGre", model, {.y = thin.force_n}));
    force.series.push_back(model);
  }
  return {force, rest};
}

}  // namespace acus::fitting
