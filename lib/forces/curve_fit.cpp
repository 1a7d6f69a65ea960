#include "forces/curve_fit.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "math/statistics.h"

namespace acus::forces {
namespace {

constexpr double kStickMm = 4.0;         // An embedded needle's shaft slides after this travel.
constexpr double kShortestRiseMm = 0.3;  // A rise over less depth has no shape to fit.
constexpr double kShortestLineMm = 3.0;  // Nor does a line.
constexpr double kRoundedPeakMm = 0.2;   // Next to a peak that is not sharp the law does not hold.
constexpr double kReversalMm = 3.0;      // Travel in which friction has turned round, at least...
constexpr double kReversalShare = 0.2;   // ...or this share of the way out.
constexpr double kShortestHoldS = 1.0;

struct Samples {
  std::vector<double> x;
  std::vector<double> y;
  std::vector<std::size_t> index;

  void Add(std::size_t i, double at, double value) {
    index.push_back(i);
    x.push_back(at);
    y.push_back(value);
  }
  double Span() const { return x.empty() ? 0.0 : *std::ranges::max_element(x) - *std::ranges::min_element(x); }
};

/// a - b, of independent estimates.
Estimate Difference(const Estimate& a, const Estimate& b) {
  const double value = a.value - b.value;
  const double down = std::hypot(a.value - a.low, b.high - b.value);
  const double up = std::hypot(a.high - a.value, b.value - b.low);
  return {value, std::hypot(a.standard_error, b.standard_error), value - down, value + up};
}

/// With another uncertainty: anything within +- half, equally likely.
Estimate Widened(Estimate estimate, double half) {
  estimate.low -= half;
  estimate.high += half;
  estimate.standard_error = std::hypot(estimate.standard_error, half / std::sqrt(3.0));
  return estimate;
}

/// Parameters: value at `middle`, slope.
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

/// Parameters: contact depth, a1, a2, baseline[, baseline slope].
SampleModel Rise(double from_mm) {
  return [from_mm](std::span<const double> p, double depth_mm, std::span<double> gradient) {
    const double x = std::max(0.0, depth_mm - p[0]);
    gradient[0] = x > 0.0 ? -p[1] - 2.0 * p[2] * x : 0.0;
    gradient[1] = x;
    gradient[2] = x * x;
    gradient[3] = 1.0;
    double value = p[3] + (p[1] + p[2] * x) * x;
    if (p.size() > 4) {
      gradient[4] = depth_mm - from_mm;
      value += p[4] * (depth_mm - from_mm);
    }
    return value;
  };
}

/// Parameters: final force, force that relaxes, logarithm of its time constant.
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

/// The best contact depth on a grid, with the other parameters from linear least squares: the
/// start from which the fit finds the global minimum.
std::vector<double> StartOfRise(const Samples& samples, bool sloped, double from_mm, double to_mm) {
  const std::size_t stride = std::max<std::size_t>(1, samples.x.size() / 400);
  const Eigen::Index num_linear = sloped ? 4 : 3;
  std::vector<double> best;
  double least = std::numeric_limits<double>::infinity();
  for (int g = 0; g < 60; ++g) {
    const double contact = from_mm + (to_mm - from_mm) * g / 60.0;
    const auto rows = static_cast<Eigen::Index>((samples.x.size() + stride - 1) / stride);
    Eigen::MatrixXd a(rows, num_linear);
    Eigen::VectorXd b(rows);
    for (Eigen::Index r = 0; r < rows; ++r) {
      const auto i = static_cast<std::size_t>(r) * stride;
      const double x = std::max(0.0, samples.x[i] - contact);
      a(r, 0) = x;
      a(r, 1) = x * x;
      a(r, 2) = 1.0;
      if (sloped) a(r, 3) = samples.x[i] - from_mm;
      b(r) = samples.y[i];
    }
    const Eigen::VectorXd p = a.colPivHouseholderQr().solve(b);
    const double squares = (a * p - b).squaredNorm();
    if (!(squares < least) || p(0) < 0.0) continue;
    least = squares;
    best = {contact, p(0), p(1), p(2)};
    if (sloped) best.push_back(p(3));
  }
  return best;
}

/// One recording on its way to a fit.
class Fitter {
 public:
  explicit Fitter(const ForceCurve& curve) : curve_(curve) {
    fit_.name = curve.name;
    fit_.phases = FindPhases(curve);
    fit_.model_n.assign(curve.size(), std::numeric_limits<double>::quiet_NaN());
  }

  PunctureCurveFit Run() {
    if (phases().advance.size() < 10) {
      fit_.message = "the drive does not advance; are depth and force in the right columns?";
      return std::move(fit_);
    }
    FitOffset();
    FitAdvance();
    FitRetraction();
    FitHold();
    if (phases().punctures.empty()) {
      fit_.message = Message("no puncture: the force never falls by ", phases().least_drop_n,
                             " N within 3 mm while the needle advances");
      return std::move(fit_);
    }
    FitRise();
    FitPlateau();
    return std::move(fit_);
  }

 private:
  const CurvePhases& phases() const { return fit_.phases; }
  const PunctureEvent& main_event() const { return phases().punctures[fit_.main]; }

  void Draw(const ModelFit& fit, const SampleModel& model, const Samples& samples) {
    std::vector<double> gradient(fit.parameters.size());
    for (std::size_t i = 0; i < samples.x.size(); ++i) {
      fit_.model_n[samples.index[i]] = model(fit.parameters, samples.x[i], gradient);
    }
  }

  void FitOffset();
  void FitAdvance();
  void FitRetraction();
  void FitHold();
  void FitRise();
  void FitPlateau();
  void LocatePuncture(const ModelFit& rise);
  double FirstForceMm() const;
  /// Zero, with the offset's uncertainty times `factor`.
  Estimate OffsetError(double factor) const {
    if (!fit_.offset_n) return {};
    const double half = factor * (fit_.offset_n->high - fit_.offset_n->value);
    return {0.0, factor * fit_.offset_n->standard_error, -half, half};
  }
  double OffsetN() const { return fit_.offset_n ? fit_.offset_n->value : 0.0; }

  const ForceCurve& curve_;
  PunctureCurveFit fit_;
  Samples rest_;
  std::optional<ModelFit> rise_;
  std::optional<SampleModel> rise_model_;
};

void Fitter::FitOffset() {
  for (std::size_t i = phases().rest.begin; i < phases().rest.end; ++i) {
    rest_.Add(i, curve_.depth_mm[i], curve_.force_n[i]);
  }
  const SampleModel constant = [](std::span<const double> p, double, std::span<double> gradient) {
    gradient[0] = 1.0;
    return p[0];
  };
  if (rest_.x.size() < 10) return;
  const ModelFit fit = FitModel(constant, rest_.x, rest_.y, {math::Median(rest_.y)}, true);
  if (fit.converged) fit_.offset_n = fit.Of(0);
}

/// The trend of the whole insertion, and whether it began inside the tissue.
void Fitter::FitAdvance() {
  Samples all;
  const double begin_mm = curve_.depth_mm[phases().advance.begin];
  double early_n[2] = {0.0, 0.0};
  for (std::size_t i = phases().advance.begin; i < phases().advance.end; ++i) {
    const double travel_mm = curve_.depth_mm[i] - begin_mm;
    if (travel_mm < kStickMm) early_n[0] = phases().smooth_n[i] - OffsetN();
    if (travel_mm < 2.0 * kStickMm) early_n[1] = phases().smooth_n[i] - OffsetN();
    if (phases().moving_in[i] && travel_mm > kStickMm) all.Add(i, curve_.depth_mm[i], curve_.force_n[i]);
  }
  if (all.Span() < 2.0 * kStickMm) return;
  const bool early_peak = !phases().punctures.empty() &&
      curve_.depth_mm[phases().punctures[0].peak] - begin_mm < 2.0 * kStickMm;
  fit_.starts_in_tissue = !early_peak && early_n[0] > phases().least_drop_n &&
                          early_n[0] > 2.0 * (early_n[1] - early_n[0]);
  const ModelFit fit = FitLine(all, math::Mean(all.x));
  if (fit.converged && fit_.starts_in_tissue) fit_.advance_slope_n_per_mm = fit.Of(1);
}

void Fitter::FitRise() {
  for (std::size_t k = 0; k < phases().punctures.size(); ++k) {
    if (phases().punctures[k].drop_n > main_event().drop_n) fit_.main = k;
  }
  const PunctureEvent& event = main_event();
  const double advance_from_mm = curve_.depth_mm[phases().advance.begin];
  double from_mm = fit_.starts_in_tissue ? advance_from_mm + kStickMm : advance_from_mm;
  if (fit_.main > 0) {
    from_mm = std::max(from_mm, curve_.depth_mm[phases().punctures[fit_.main - 1].trough]);
  }
  const bool free_approach = fit_.main == 0 && !fit_.starts_in_tissue;
  const double last_mm = curve_.depth_mm[event.peak] - (event.sharp ? 0.0 : kRoundedPeakMm);
  Samples rise;
  if (free_approach) rise = rest_;  // In air the force is the sensor's offset, at rest as before.
  for (std::size_t i = phases().advance.begin; i <= event.peak; ++i) {
    const double depth_mm = curve_.depth_mm[i];
    if (depth_mm >= from_mm && depth_mm <= last_mm) rise.Add(i, depth_mm, curve_.force_n[i]);
  }
  if (rise.x.size() < 12 || last_mm - from_mm < kShortestRiseMm) {
    fit_.message = Message("the rise before the puncture at ", curve_.depth_mm[event.peak],
                           " mm is too short to fit: ", last_mm - from_mm, " mm, ", rise.x.size(),
                           " samples");
    return;
  }
  const std::vector<double> start = StartOfRise(rise, !free_approach, from_mm, last_mm);
  if (start.empty()) {
    fit_.message = "the force before the puncture does not rise like a1 x + a2 x^2 with a1 >= 0";
    return;
  }
  rise_model_ = Rise(from_mm);
  rise_ = FitModel(*rise_model_, rise.x, rise.y, start, false);
  fit_.rise_rms_n = rise_->rms_n;
  if (!rise_->converged) {
    fit_.message = "the fit of the rise did not converge: " + rise_->message;
    return;
  }
  if (free_approach && !fit_.offset_n) fit_.offset_n = rise_->Of(3);
  fit_.contact_depth_mm = rise_->Of(0);
  fit_.a1_n_per_mm = rise_->Of(1);
  fit_.a2_n_per_mm2 = rise_->Of(2);
  Draw(*rise_, *rise_model_, rise);
  fit_.converged = true;
  LocatePuncture(*rise_);
}

/// Depth and force of the puncture. A sharp one lies between its two samples; at a rounded peak the
/// smoothing is the uncertainty.
void Fitter::LocatePuncture(const ModelFit& rise) {
  const PunctureEvent& event = main_event();
  const std::size_t reach = event.sharp ? 0 : phases().smoothing;
  const std::size_t a = event.peak - std::min(event.peak, reach);
  const std::size_t b = std::min(curve_.size() - 1, event.peak + std::max<std::size_t>(1, reach));
  const double at_mm = event.sharp ? 0.5 * (curve_.depth_mm[a] + curve_.depth_mm[b])
                                   : curve_.depth_mm[event.peak];
  const double half_mm = std::max(at_mm - curve_.depth_mm[a], curve_.depth_mm[b] - at_mm);
  const Estimate at{at_mm, half_mm / std::sqrt(3.0), at_mm - half_mm, at_mm + half_mm};
  fit_.puncture_depth_mm = Difference(at, *fit_.contact_depth_mm);
  const double x = fit_.puncture_depth_mm->value;
  const double slope = rise.parameters[1] + 2.0 * rise.parameters[2] * x;
  Eigen::VectorXd gradient =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rise.parameters.size()));
  gradient(0) = -slope;
  gradient(1) = x;
  gradient(2) = x * x;
  fit_.puncture_n =
      Widened(rise.Of((rise.parameters[1] + rise.parameters[2] * x) * x, gradient),
              std::abs(slope) * half_mm);
}

void Fitter::FitPlateau() {
  const PunctureEvent& event = main_event();
  const double puncture_mm = 0.5 * (curve_.depth_mm[event.peak] + curve_.depth_mm[event.trough]);
  Samples plateau;
  for (std::size_t i = event.trough; i < phases().advance.end; ++i) {
    if (phases().moving_in[i]) plateau.Add(i, curve_.depth_mm[i], curve_.force_n[i]);
  }
  if (plateau.Span() < kShortestLineMm) return;
  const ModelFit line = FitLine(plateau, puncture_mm);
  fit_.plateau_rms_n = line.rms_n;
  if (!line.converged) return;
  fit_.plateau_slope_n_per_mm = line.Of(1);
  fit_.plateau_n = fit_.offset_n ? Difference(line.Of(0), *fit_.offset_n) : line.Of(0);
  Draw(line, Line(puncture_mm), plateau);
  if (!rise_ || !fit_.converged) return;
  std::vector<double> gradient(rise_->parameters.size());
  const double before_n = (*rise_model_)(rise_->parameters, puncture_mm, gradient);
  const Eigen::VectorXd g = Eigen::Map<const Eigen::VectorXd>(
      gradient.data(), static_cast<Eigen::Index>(gradient.size()));
  // Where in the fall the puncture was is not known better than this.
  const double half_mm = 0.5 * (curve_.depth_mm[event.trough] - curve_.depth_mm[event.peak]);
  const double slope = rise_->parameters[1] - line.parameters[1] +
                       2.0 * rise_->parameters[2] * (puncture_mm - rise_->parameters[0]);
  fit_.drop_n = Widened(Difference(rise_->Of(before_n, g), line.Of(0)), std::abs(slope) * half_mm);
}

/// Drive depth at which a force is first felt: on the way out the needle leaves the tissue there.
double Fitter::FirstForceMm() const {
  for (std::size_t i = phases().advance.begin; i < phases().advance.end; ++i) {
    if (phases().smooth_n[i] > OffsetN() + phases().least_drop_n) return curve_.depth_mm[i];
  }
  return curve_.depth_mm[phases().advance.begin];
}

void Fitter::FitRetraction() {
  const SampleRange range = phases().retract;
  if (range.size() < 20) return;
  const double deepest_mm = curve_.depth_mm[range.begin];
  const double least_mm = curve_.depth_mm[range.end - 1];
  const double turned_mm =
      deepest_mm - std::max(kReversalMm, kReversalShare * (deepest_mm - least_mm));
  const double surface_mm = fit_.starts_in_tissue ? least_mm + kStickMm : FirstForceMm();
  Samples samples;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const double depth_mm = curve_.depth_mm[i];
    if (depth_mm < turned_mm && depth_mm > surface_mm) samples.Add(i, depth_mm, curve_.force_n[i]);
  }
  if (samples.Span() < kShortestLineMm) return;
  const double middle_mm = math::Mean(samples.x);
  const ModelFit line = FitLine(samples, middle_mm);
  fit_.friction_rms_n = line.rms_n;
  if (!line.converged) return;
  fit_.friction_n_per_mm = line.Of(1, -1.0);
  Draw(line, Line(middle_mm), samples);
}

void Fitter::FitHold() {
  const SampleRange range = phases().hold;
  if (range.size() < 20 ||
      curve_.time_s[range.end - 1] - curve_.time_s[range.begin] < kShortestHoldS) {
    return;
  }
  // The drive stopped where its straight advance meets the greatest depth.
  const std::size_t last = phases().advance.end - 1;
  std::size_t moving = last;
  while (moving > phases().advance.begin && !phases().moving_in[moving]) --moving;
  const double hold_mm = curve_.depth_mm[range.begin + range.size() / 2];
  const double start_s = std::clamp(
      curve_.time_s[moving] + (hold_mm - curve_.depth_mm[moving]) / phases().advance_mm_per_s,
      curve_.time_s[moving], curve_.time_s[range.begin]);
  Samples samples;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    samples.Add(i, curve_.time_s[i], curve_.force_n[i]);
  }
  const double end_n = math::Median(std::span(samples.y).last(samples.y.size() / 4));
  const double begin_n = math::Median(std::span(samples.y).first(samples.y.size() / 50 + 3));
  const double third_n = end_n + (begin_n - end_n) / std::exp(1.0);
  double tau_s = 0.2 * (samples.x.back() - start_s);
  for (std::size_t i = range.begin; i < range.end; ++i) {
    if ((phases().smooth_n[i] - third_n) * (begin_n - end_n) > 0.0) continue;
    tau_s = std::max(0.02, curve_.time_s[i] - start_s);
    break;
  }
  const SampleModel model = Relaxation(start_s);
  const ModelFit fit =
      FitModel(model, samples.x, samples.y, {end_n, begin_n - end_n, std::log(tau_s)}, true);
  fit_.relaxation_rms_n = fit.rms_n;
  if (!fit.converged) return;
  const double tau = std::exp(fit.parameters[2]);
  const double base_n = fit.parameters[0] - OffsetN();
  const double total_n = base_n + fit.parameters[1];
  if (!(std::abs(total_n) > 1e-9) || tau > 3.0 * (samples.x.back() - start_s)) return;
  Eigen::VectorXd gradient(3);
  gradient << -fit.parameters[1] / (total_n * total_n), base_n / (total_n * total_n), 0.0;
  const double from_offset = std::abs(fit.parameters[1]) / (total_n * total_n);
  fit_.relaxation_fraction =
      Difference(fit.Of(fit.parameters[1] / total_n, gradient), OffsetError(from_offset));
  gradient << 0.0, 0.0, tau;
  fit_.relaxation_time_s = fit.Of(tau, gradient);
  Draw(fit, model, samples);
}

}  // namespace

std::vector<std::pair<std::string, Estimate>> PunctureCurveFit::Estimates() const {
  std::vector<std::pair<std::string, Estimate>> all;
  const auto add = [&](const char* key, const std::optional<Estimate>& estimate) {
    if (estimate) all.emplace_back(key, *estimate);
  };
  add("offset_n", offset_n);
  add("contact_depth_mm", contact_depth_mm);
  add("a1_n_per_mm", a1_n_per_mm);
  add("a2_n_per_mm2", a2_n_per_mm2);
  add("puncture_depth_mm", puncture_depth_mm);
  add("puncture_n", puncture_n);
  add("drop_n", drop_n);
  add("plateau_n", plateau_n);
  add("plateau_slope_n_per_mm", plateau_slope_n_per_mm);
  add("friction_n_per_mm", friction_n_per_mm);
  add("relaxation_fraction", relaxation_fraction);
  add("relaxation_time_s", relaxation_time_s);
  add("advance_slope_n_per_mm", advance_slope_n_per_mm);
  return all;
}

PunctureCurveFit FitPunctureCurve(const ForceCurve& curve) { return Fitter(curve).Run(); }

}  // namespace acus::forces
