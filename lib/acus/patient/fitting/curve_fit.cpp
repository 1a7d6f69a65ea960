#include "acus/patient/fitting/curve_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/curve_fit_phases.h"

namespace acus::fitting {
namespace {

constexpr double kShortestRiseMm = 0.3;  // A rise over less depth has no shape to fit.
constexpr double kShortestLineMm = 3.0;  // Nor does a line.
constexpr double kBaselineMm = 2.0;      // Taken along before a rise inside the tissue.
constexpr double kLongestRiseMm = 15.0;  // Inside the tissue; farther back it is another matter.
constexpr double kEarlierShare = 0.4;  // A peak this high, relative to the fall, is an earlier one.
constexpr double kEntryShareOfLargest = 0.15;  // Of the largest fall: a smaller one is no entry.
constexpr double kRoundedShare = 0.9;          // Of the height of a peak that is not sharp.

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
    FitOffset(curve_, fit_);
    if (SignIsReversed(curve_, fit_)) {
      fit_.message = kReversedSign;
      return std::move(fit_);
    }
    FitAdvance(curve_, fit_);
    FitRetraction(curve_, fit_);
    FitHold(curve_, fit_);
    if (phases().punctures.empty()) {
      fit_.message = Message("no puncture: the force never falls by ", phases().least_drop_n,
                             " N within 3 mm while the needle advances");
      return std::move(fit_);
    }
    FitFirstThatAnswers();
    return std::move(fit_);
  }

 private:
  const CurvePhases& phases() const { return fit_.phases; }
  const PunctureEvent& main_event() const { return phases().punctures[fit_.main]; }

  void FitFirstThatAnswers();
  std::vector<std::size_t> Candidates();
  void FitRise();
  bool ShowsZero();
  void HoldOtherTerm(RiseLaw law, const Samples& rise);
  bool TryRise(const RiseLaw& law, const Samples& rise, double last_mm);
  Samples RiseSamples(double slope_n_per_mm, double& from_mm) const;
  /// The main puncture is the first thing that a needle from outside meets.
  bool IsFreeApproach() const { return fit_.main == entry_; }
  Estimate A1() const { return law_.has_a1 ? rise_->Of(2) : held_; }
  Estimate A2() const { return law_.has_a2 ? rise_->Of(law_.has_a1 ? 3 : 2) : held_; }
  void FitPlateau();
  void LocatePuncture(const ModelFit& rise);

  const ForceCurve& curve_;
  PunctureCurveFit fit_;
  std::optional<ModelFit> rise_;
  RiseLaw law_;
  std::optional<std::size_t> entry_;  ///< Of the punctures: where the needle comes in, if it does.
  Estimate held_;                     ///< Of the term that is held at 0.
  bool shows_zero_ = true;            ///< The recording has the sensor's zero.
};

/// Samples of the rise before the main puncture, and the depth they begin at.
Samples Fitter::RiseSamples(double slope_n_per_mm, double& from_mm) const {
  const PunctureEvent& event = main_event();
  const std::vector<double>& smooth = phases().smooth_n;
  const double first_mm = curve_.depth_mm[phases().advance.begin];
  const bool free_approach = IsFreeApproach();
  std::size_t begin = phases().advance.begin;
  from_mm = first_mm;
  if (!free_approach) {
    // In tissue the rise stands on the friction of the shaft. Going back from the peak it begins
    // where the force above that is least, before an earlier peak; kBaselineMm before it are taken
    // along to find its level.
    const auto above = [&](std::size_t i) {
      return smooth[i] - slope_n_per_mm * curve_.depth_mm[i];
    };
    const double earlier_n = std::max(phases().least_drop_n, kEarlierShare * event.drop_n);
    double limit_mm = curve_.depth_mm[event.peak] - kLongestRiseMm;
    if (fit_.starts_in_tissue) limit_mm = std::max(limit_mm, first_mm + kStickMm);
    std::size_t least = event.peak;
    std::size_t i = event.peak;
    for (; i > begin && curve_.depth_mm[i] > limit_mm; --i) {
      if (above(i) < above(least)) least = i;
      if (above(i) > above(least) + earlier_n) break;
    }
    const double least_mm = curve_.depth_mm[least];
    while (begin < i || curve_.depth_mm[begin] < least_mm - kBaselineMm) ++begin;
    from_mm = curve_.depth_mm[begin];
  }
  const double top_n = smooth[event.peak];
  double base_n = top_n;
  for (std::size_t i = begin; i < event.peak; ++i) base_n = std::min(base_n, smooth[i]);
  Samples rise;
  if (free_approach)
    rise = RestSamples(curve_,
                       phases());  // In air the force is the sensor's offset, at rest as before.
  for (std::size_t i = begin; i <= event.peak; ++i) {
    if (curve_.depth_mm[i] < from_mm) continue;
    // A peak that is not sharp is rounded: the membrane tears little by little. Its law ends there.
    if (!event.sharp && smooth[i] > base_n + kRoundedShare * (top_n - base_n)) break;
    rise.Add(i, curve_.depth_mm[i], curve_.force_n[i]);
  }
  return rise;
}

/// Punctures in the order in which they are tried.
std::vector<std::size_t> Fitter::Candidates() {
  const std::vector<PunctureEvent>& events = phases().punctures;
  std::vector<std::size_t> order(events.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](std::size_t k) { return events[k].drop_n; });
  if (fit_.starts_in_tissue) return order;
  const double least_n = kEntryShareOfLargest * events[order[0]].drop_n;
  const auto entry = std::ranges::find_if(
      events, [least_n](const PunctureEvent& event) { return event.drop_n >= least_n; });
  entry_ = static_cast<std::size_t>(entry - events.begin());
  const auto at = std::ranges::find(order, *entry_);
  std::rotate(order.begin(), at, at + 1);
  return order;
}

void Fitter::FitFirstThatAnswers() {
  const PunctureCurveFit before = fit_;
  std::optional<PunctureCurveFit> first;
  for (const std::size_t k : Candidates()) {
    fit_ = before;
    fit_.main = k;
    fit_.is_entry = IsFreeApproach();
    rise_.reset();
    FitRise();
    if (!shows_zero_) return;
    FitPlateau();
    if (fit_.converged) return;
    if (!first) first = fit_;
  }
  fit_ = std::move(*first);
}

void Fitter::FitRise() {
  RiseLaw law;
  if (!IsFreeApproach() && fit_.advance_slope_n_per_mm) {
    law.slope_n_per_mm = std::max(0.0, fit_.advance_slope_n_per_mm->value);
  }
  const Samples rise = RiseSamples(law.slope_n_per_mm, law.from_mm);
  const double last_mm = rise.x.empty() ? law.from_mm : rise.x.back();
  if (rise.x.size() < 12 || last_mm - law.from_mm < kShortestRiseMm) {
    fit_.message = Message("the rise before the puncture at ", curve_.depth_mm[main_event().peak],
                           " mm is too short to fit: ", last_mm - law.from_mm, " mm, ",
                           rise.x.size(), " samples");
    return;
  }
  // Both terms; only if one of them comes out below 0, or cannot be distinguished from the contact
  // depth (as a1 near 0), the better of the two laws with one term. In air the law is known to
  // hold, and an estimate may be below 0 by its error, or the interval would not be fair.
  const auto is_negative = [&](const Estimate& term) {
    return (IsFreeApproach() ? term.high : term.value) < 0.0;
  };
  if (!TryRise(law, rise, last_mm) || is_negative(A1()) || is_negative(A2())) {
    rise_.reset();
    RiseLaw one = law;
    one.has_a1 = false;
    const bool quadratic = TryRise(one, rise, last_mm);
    const double quadratic_rms_n = quadratic ? rise_->rms_n : 0.0;
    std::swap(one.has_a1, one.has_a2);
    const bool linear = TryRise(one, rise, last_mm);
    if (quadratic && !(linear && rise_->rms_n < quadratic_rms_n)) {
      std::swap(one.has_a1, one.has_a2);
      TryRise(one, rise, last_mm);
    }
    if (!quadratic && !linear) {
      fit_.message = "the force before the puncture does not rise like a1 x + a2 x^2";
      return;
    }
    HoldOtherTerm(law, rise);
  }
  fit_.rise_rms_n = rise_->rms_n;
  if (IsFreeApproach() && !fit_.offset_n) {
    shows_zero_ = ShowsZero();
    if (!shows_zero_) return;
    fit_.offset_n = rise_->Of(1);
  }
  fit_.contact_depth_mm = rise_->Of(0);
  fit_.a1_n_per_mm = A1().AtLeast(0.0);
  fit_.a2_n_per_mm2 = A2().AtLeast(0.0);
  Draw(*rise_, law_, rise, fit_);
  fit_.converged = true;
  LocatePuncture(*rise_);
  if (fit_.puncture_n->low > 0.0) return;
  fit_.converged = false;
  fit_.message =
      Message("the rise before the fall of ", main_event().drop_n, " N at ",
              curve_.depth_mm[main_event().peak], " mm cannot be distinguished from what else ",
              "the force does there: ", fit_.puncture_n->value, " N, 95 % interval from ",
              fit_.puncture_n->low, " to ", fit_.puncture_n->high, " N");
  for (auto* estimate : {&fit_.contact_depth_mm, &fit_.a1_n_per_mm, &fit_.a2_n_per_mm2,
                         &fit_.puncture_depth_mm, &fit_.puncture_n}) {
    estimate->reset();
  }
}

/// Whether there are samples before contact, or it does not matter as the fitted zero is that of
/// the recording. Otherwise the first sample may be inside tissue, or the sensor's zero may be off.
bool Fitter::ShowsZero() {
  const double first_mm = curve_.depth_mm[phases().advance.begin];
  const double zero_n = rise_->parameters[1];
  if (rise_->Of(0).low > first_mm || std::abs(zero_n) < phases().least_drop_n) return true;
  fit_.message = Message(
      "the force rises from the first sample on, at ", first_mm, " mm, where it is ", zero_n,
      " N: either the recording begins inside tissue, or the sensor's zero is off by as much. "
      "Record a rest, or 1.5 mm through air, before contact");
  return false;
}

/// The term that is held at 0: what it could be, with the contact depth as it is.
void Fitter::HoldOtherTerm(RiseLaw law, const Samples& rise) {
  const double contact_mm = rise_->parameters[0];
  const SampleModel fixed_contact = [&](std::span<const double> p, double x, std::span<double> g) {
    const double all[] = {contact_mm, p[0], p[1], p[2]};
    double gradient[4];
    const double value = law(all, x, gradient);
    std::copy(gradient + 1, gradient + 4, g.begin());
    return value;
  };
  const ModelFit fit =
      FitModel(fixed_contact, rise.x, rise.y, {rise_->parameters[1], 0.0, 0.0}, false);
  const Estimate free = fit.Of(law_.has_a1 ? 2 : 1);
  held_ = Estimate{0.0, free.standard_error, 0.0, std::max(free.high - free.value, free.high)};
  fit_.message = law_.has_a1 ? "a2 is held at 0: the rise is not convex"
                             : "a1 is held at 0: the rise begins too gently to determine it";
}

bool Fitter::TryRise(const RiseLaw& law, const Samples& rise, double last_mm) {
  const std::vector<double> start = StartOfRise(rise, law, last_mm);
  if (start.empty()) return false;
  law_ = law;
  rise_ = FitModel(law_, rise.x, rise.y, start, false);
  return rise_->converged;
}

/// Depth and force of the puncture. A sharp one lies between its two samples; at a rounded peak the
/// smoothing is the uncertainty.
void Fitter::LocatePuncture(const ModelFit& rise) {
  const PunctureEvent& event = main_event();
  const std::size_t reach = event.sharp ? 0 : phases().smoothing;
  const std::size_t a = event.peak - std::min(event.peak, reach);
  const std::size_t b = std::min(curve_.size() - 1, event.peak + std::max<std::size_t>(1, reach));
  const double at_mm =
      event.sharp ? 0.5 * (curve_.depth_mm[a] + curve_.depth_mm[b]) : curve_.depth_mm[event.peak];
  const double half_mm = std::max(at_mm - curve_.depth_mm[a], curve_.depth_mm[b] - at_mm);
  const Estimate at{at_mm, half_mm / std::sqrt(3.0), at_mm - half_mm, at_mm + half_mm};
  fit_.puncture_depth_mm = Difference(at, *fit_.contact_depth_mm);
  const double x = fit_.puncture_depth_mm->value;
  const double a1 = law_.A1(rise.parameters);
  const double a2 = law_.A2(rise.parameters);
  Eigen::VectorXd gradient(static_cast<Eigen::Index>(rise.parameters.size()));
  law_(rise.parameters, at_mm, {gradient.data(), rise.parameters.size()});
  gradient(1) = 0.0;  // Above the baseline.
  fit_.puncture_n =
      Widened(rise.Of((a1 + a2 * x) * x, gradient), std::abs(gradient(0)) * half_mm).AtLeast(0.0);
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
  fit_.plateau_n =
      (fit_.offset_n ? Difference(line.Of(0), *fit_.offset_n) : line.Of(0)).AtLeast(0.0);
  Draw(line, Line(puncture_mm), plateau, fit_);
  if (!rise_ || !fit_.converged) return;
  std::vector<double> gradient(rise_->parameters.size());
  const double before_n = law_(rise_->parameters, puncture_mm, gradient);
  const Eigen::VectorXd g = Eigen::Map<const Eigen::VectorXd>(
      gradient.data(), static_cast<Eigen::Index>(gradient.size()));
  // Where in the fall the puncture was is not known better than this.
  const double half_mm = 0.5 * (curve_.depth_mm[event.trough] - curve_.depth_mm[event.peak]);
  const double slope = law_.slope_n_per_mm - gradient[0] - line.parameters[1];
  fit_.drop_n = Widened(Difference(rise_->Of(before_n, g), line.Of(0)), std::abs(slope) * half_mm)
                    .AtLeast(0.0);
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

PunctureCurveFit FitPunctureCurve(const ForceCurve& curve) {
  return Fitter(curve).Run();
}

}  // namespace acus::fitting
