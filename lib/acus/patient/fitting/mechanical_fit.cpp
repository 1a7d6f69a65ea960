#include "acus/patient/fitting/mechanical_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/curve_fit_phases.h"
#include "acus/patient/fitting/curve_models.h"
#include "acus/patient/fitting/depth_bins.h"
#include "acus/patient/fitting/hold_slips.h"
#include "acus/patient/fitting/shared_fit.h"

namespace acus::fitting {
namespace {

constexpr double kIntegrationStepS = 0.02;  // The fit's samples: means over so long...
constexpr double kEventStepMm = 0.15;       // ...or, to find events, over so much travel.
constexpr double kShortestMm = 3.0;
constexpr double kFreeKnotMm = 8.0;  // Of the profiles beside which the shared part is fitted.
constexpr double kShortestRelaxationS = 1.0;
constexpr int kMostSlips = 6;    // Of one hold.
constexpr int kShareRounds = 3;  // Of fitting a slip and the relaxation beside it.
constexpr int kMostRelaxing = static_cast<int>(MechanicalModel::kMostBranches);
constexpr double kLeastEventN = 0.08;  // Smaller ones are the tissue's texture.

/// `model` with a knot every kFreeKnotMm: what punctures do to the force must not be taken for
/// build-up or relaxation.
MechanicalModel WithFreeProfiles(MechanicalModel model) {
  const double first_mm = model.in.depth_mm.front();
  const double last_mm = model.in.depth_mm.back();
  const int intervals = std::max(1, static_cast<int>((last_mm - first_mm) / kFreeKnotMm));
  model.in.depth_mm.clear();
  for (int k = 0; k <= intervals; ++k) {
    model.in.depth_mm.push_back(first_mm + (last_mm - first_mm) * k / intervals);
  }
  model.in.force_n.assign(model.in.depth_mm.size(), 0.0);
  model.out = model.in;
  return model;
}

double LineRms(const ForceCurve& curve, const SampleRange& range) {
  if (range.size() < 3) return 0.0;
  Samples samples;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    samples.Add(i, curve.depth_mm[i], curve.force_n[i]);
  }
  return FitModel(Line(math::Mean(samples.x)), samples.x, samples.y, {0.0, 0.0}, false).rms_n;
}

/// Two knots over the insertion; events and profiles stand on it.
MechanicalModel EmptyModel(const ForceCurve& curve, const PunctureCurveFit& puncture) {
  MechanicalModel model;
  const CurvePhases& phases = puncture.phases;
  const double first_mm = OriginMm(curve, puncture);
  if (!puncture.starts_in_tissue) model.surface_mm = first_mm;
  model.in.depth_mm = {first_mm, curve.depth_mm[phases.advance.end - 1]};
  model.in.force_n = {0.0, 0.0};
  model.out = model.in;
  model.offset_n = puncture.offset_n ? puncture.offset_n->value : 0.0;
  model.reference_mm_per_s = std::max(0.01, phases.advance_mm_per_s);
  model.start_s = curve.time_s[phases.advance.begin];
  return model;
}

/// Sensor drift: only where the needle is out of the tissue again and rests.
void SetDrift(const ForceCurve& curve, const PunctureCurveFit& puncture, MechanicalModel& model,
              MechanicalFit& fit) {
  const std::size_t end = puncture.phases.retract.end;
  if (!puncture.offset_n) {
    fit.warnings.push_back("offset_n: no rest before the insertion; taken as 0");
  }
  if (puncture.starts_in_tissue) {
    fit.warnings.push_back("drift_n_per_s: the needle is never outside the tissue; taken as 0");
    fit.warnings.push_back(
        "cutting_n: the shaft is in the tissue from the start; what belongs to the tip and what to "
        "the shaft follows only from the retraction");
    return;
  }
  if (puncture.phases.retract.size() == 0 || end + 50 >= curve.size() ||
      curve.depth_mm[end] > model.surface_mm) {
    return;
  }
  const std::span<const double> after(curve.force_n.data() + end, curve.size() - end);
  const double middle_s = 0.5 * (curve.time_s[end] + curve.time_s.back());
  model.drift_n_per_s = (math::Median(after) - model.offset_n) / (middle_s - model.start_s);
}

/// Level at the profile's first knot and slope, of rows that are strained in one direction.
ModelFit LevelAndSlope(const StrainedRows& rows, const ResistanceProfile& profile) {
  const double first_mm = profile.depth_mm[0];
  std::vector<double> index(rows.depth_mm.size());
  for (std::size_t i = 0; i < index.size(); ++i) index[i] = static_cast<double>(i);
  const SampleModel line = [&](std::span<const double> p, double at, std::span<double> gradient) {
    const auto i = static_cast<std::size_t>(at);
    gradient[0] = rows.strain[i];
    gradient[1] = rows.strain[i] * (rows.depth_mm[i] - first_mm);
    return p[0] * gradient[0] + p[1] * gradient[1];
  };
  return FitModel(line, index, rows.force_n, {0.0, 0.0}, false);
}

Estimate Exponential(const Estimate& logarithm) {
  const double value = std::exp(logarithm.value);
  return {value, value * logarithm.standard_error, std::exp(logarithm.low),
          std::exp(logarithm.high)};
}

/// Force per travel where the strain is 0, of a level that is built up over `length_mm`.
Estimate Stiffness(const Estimate& level_n, const Estimate& length_mm, double steady) {
  return PositiveRatio(level_n, length_mm, 1.0 / steady);
}

/// The level at a depth behind the profile's first knot.
Estimate LevelAt(const ModelFit& line, double depth_mm) {
  Eigen::VectorXd gradient(2);
  gradient << 1.0, depth_mm;
  return line.Of(line.parameters[0] + depth_mm * line.parameters[1], gradient);
}

bool AreOne(const Estimate& a, const Estimate& b) {
  const double variance = a.standard_error * a.standard_error + b.standard_error * b.standard_error;
  const double difference = a.value - b.value;
  return difference * difference < 2.0 * variance;  // 2 per parameter is Akaike's price.
}

/// What the tip alone resists: insertion less withdrawal where the shaft is as deep. With one
/// friction for both it is the same everywhere and is taken where the two lines determine it best;
/// else where there is the least shaft.
Estimate CuttingN(const ModelFit& in, const ModelFit& out, double length_mm) {
  double at_mm = 0.0;
  if (AreOne(in.Of(1), out.Of(1))) {
    const Eigen::MatrixXd sum = in.covariance + out.covariance;
    if (sum(1, 1) > 0.0) at_mm = std::clamp(-sum(0, 1) / sum(1, 1), 0.0, length_mm);
  }
  return Difference(LevelAt(in, at_mm), LevelAt(out, at_mm)).AtLeast(0.0);
}

void AddRelaxation(const SeriesFit& shared, MechanicalFit& fit);

void AddEstimates(const PhaseSamples& samples, const SeriesFit& shared, MechanicalFit& fit) {
  const auto add = [&](const char* name, const Estimate& estimate, bool undetermined) {
    fit.estimates.emplace_back(name, estimate);
    if (undetermined) fit.undetermined.push_back(name);
  };
  const MechanicalModel& model = fit.constant;
  const std::vector<ContactStrain> strain = Strains(model, samples.all);
  const auto level = [&](const SampleRange& range, bool inwards) {
    return LevelAndSlope(RowsOf(samples.all, strain, range, inwards, model.surface_mm),
                         inwards ? model.in : model.out);
  };
  const ModelFit in = level(samples.in, true);
  const Estimate in_n = in.Of(0).AtLeast(0.0);
  add("insertion_n", in_n, !in.converged);
  add("insertion_n_per_mm", in.Of(1).AtLeast(0.0), !in.converged);
  const Estimate buildup_in = Exponential(shared.Bounded(kBuildupIn));
  add("buildup_in_mm", buildup_in, shared.undetermined[kBuildupIn]);
  add("tissue_stiffness_n_per_mm", Stiffness(in_n, buildup_in, model.SteadyStrain(true)),
      shared.undetermined[kBuildupIn]);
  const ModelFit out = samples.out.size() > 10 ? level(samples.out, false) : ModelFit{};
  if (!out.parameters.empty()) {
    const double length_mm = model.out.depth_mm[1] - model.out.depth_mm[0];
    add("withdrawal_n", out.Of(0).AtLeast(0.0), !out.converged);
    add("withdrawal_n_per_mm", out.Of(1).AtLeast(0.0), !out.converged);
    const Estimate buildup_out = Exponential(shared.Bounded(kBuildupOut));
    add("buildup_out_mm", buildup_out, shared.undetermined[kBuildupOut]);
    const Estimate end_n = LevelAt(out, length_mm).AtLeast(0.0);
    add("reversal_stiffness_n_per_mm", Stiffness(end_n, buildup_out, model.SteadyStrain(false)),
        shared.undetermined[kBuildupOut]);
    if (in.converged && out.converged) fit.cutting_n = CuttingN(in, out, length_mm);
    fit.one_friction_is_enough = AreOne(in.Of(1), out.Of(1));
  }
  AddRelaxation(shared, fit);
}

/// Shares and times are fitted relative to the branch before: what is uncertain of one branch makes
/// the later ones uncertain too.
void AddRelaxation(const SeriesFit& shared, MechanicalFit& fit) {
  constexpr Shared kShares[] = {kFirstShare, kSecondShare, kThirdShare};
  constexpr Shared kTimes[] = {kLogTau, kLogRatio, kThirdLogRatio};
  double rest = 1.0;      // What the branches before leave,
  double log_time = 0.0;  // and the logarithm of the time of the last of them.
  bool has_share = true, has_time = true;
  Eigen::VectorXd rest_slope = Eigen::VectorXd::Zero(kNumShared), time_slope = rest_slope;
  const auto add = [&](const std::string& name, const Estimate& estimate, bool undetermined) {
    fit.estimates.emplace_back(name, estimate);
    if (undetermined) fit.undetermined.push_back(name);
  };
  for (int k = 0; k < fit.relaxing_branches; ++k) {
    const std::string number = std::to_string(k + 1);
    const Estimate share = shared.Bounded(kShares[k]), time = shared.Bounded(kTimes[k]);
    has_share = has_share && !shared.undetermined[kShares[k]];
    has_time = has_time && !shared.undetermined[kTimes[k]];
    Eigen::VectorXd share_slope = share.value * rest_slope;
    share_slope(kShares[k]) = rest;
    Estimate part = shared.Of(rest * share.value, share_slope);
    if (!has_share) part = {part.value, 1.0, 0.0, 1.0};
    part.low = std::max(0.0, part.low);
    part.high = std::min(1.0, part.high);
    add("relaxing_share_" + number, part, !has_share);
    time_slope(kTimes[k]) = 1.0;
    const Estimate sum = shared.Of(log_time + time.value, time_slope);
    const double low = log_time + time.low, high = log_time + time.high;
    add("relaxation_" + number + "_s",
        Exponential(has_time ? sum : Estimate{sum.value, high - low, low, high}), !has_time);
    rest_slope = (1.0 - share.value) * rest_slope;
    rest_slope(kShares[k]) = -rest;
    rest *= 1.0 - share.value;
    log_time += time.value;
  }
}

/// One recording on its way to a mechanical model.
class MechanicalFitter {
 public:
  MechanicalFitter(const ForceCurve& curve, const PunctureCurveFit& puncture)
      : curve_(curve), puncture_(puncture), phases_(puncture.phases) {}

  MechanicalFit Run(const MechanicalOptions& options) {
    if (phases_.advance.size() < 60 ||
        curve_.depth_mm[phases_.advance.end - 1] - curve_.depth_mm[phases_.advance.begin] <
            2.0 * kShortestMm) {
      fit_.message = "the insertion is too short for a mechanical model";
      return std::move(fit_);
    }
    if (SignIsReversed(curve_, puncture_)) {
      fit_.message = kReversedSign;
      return std::move(fit_);
    }
    Prepare();
    FitBesideFreeProfiles();
    fit_.eventful = WithHoldOf(empty_);
    if (options.find_events) {
      FindEvents();
      // Build-up and relaxation again, now that the events are no longer in the data.
      WeightedFit(fit_.eventful);
    }
    fit_.constant = WithHoldOf(empty_);
    fit_.eventful = options.find_events ? WithHoldOf(fit_.eventful) : fit_.constant;
    Judge();
    return std::move(fit_);
  }

 private:
  void Prepare();
  void FitBesideFreeProfiles();
  void WeightedFit(const MechanicalModel& model);
  MechanicalModel WithHoldOf(const MechanicalModel& model) const;
  void FindEvents();
  void Judge();

  const ForceCurve& curve_;
  const PunctureCurveFit& puncture_;
  const CurvePhases& phases_;
  bool has_hold_ = false;
  bool has_out_ = false;
  MechanicalModel empty_;
  PhaseSamples samples_;
  SeriesFit shared_;
  MechanicalFit fit_;
};

void MechanicalFitter::Prepare() {
  empty_ = EmptyModel(curve_, puncture_);
  SetDrift(curve_, puncture_, empty_, fit_);
  const SampleRange hold = HoldRange(phases_);
  has_hold_ = hold.size() > 20 &&
              curve_.time_s[hold.end - 1] - curve_.time_s[hold.begin] > kShortestRelaxationS;
  has_out_ = phases_.retract.size() > 50;
  if (!has_hold_) fit_.warnings.push_back("relaxation: no hold shows it; none assumed");
  if (!has_out_) {
    fit_.warnings.push_back("withdrawal: no retraction shows it; taken as the insertion's");
  }
  samples_ = ThinPhases(curve_, phases_, empty_, kIntegrationStepS);
}

void MechanicalFitter::FitBesideFreeProfiles() {
  SharedFit one(samples_, WithFreeProfiles(empty_));
  shared_ = one.Run(SharedParameters(has_hold_, has_out_, 1), false);
  fit_.relaxing_branches = has_hold_ ? 1 : 0;
  for (int branches = 2; has_hold_ && branches <= kMostRelaxing; ++branches) {
    SharedFit more(samples_, WithFreeProfiles(empty_));
    SeriesFit fit = more.Run(SharedParameters(has_hold_, has_out_, branches), false);
    if (!fit.converged || !(fit.aic < shared_.aic)) continue;
    shared_ = std::move(fit);
    fit_.relaxing_branches = branches;
  }
  WeightedFit(WithFreeProfiles(empty_));
}

/// Each phase weighted by what it can say.
void MechanicalFitter::WeightedFit(const MechanicalModel& model) {
  std::vector<SeriesParameter> parameters =
      SharedParameters(has_hold_, has_out_, fit_.relaxing_branches);
  for (std::size_t k = 0; k < kNumShared; ++k) {
    parameters[k].start = std::clamp(shared_.parameters[k], parameters[k].low, parameters[k].high);
  }
  SharedFit weighted(samples_, model);
  weighted.WeighByResidual(shared_.parameters);
  shared_ = weighted.Run(parameters, true);
}

/// The model with this recording's build-up, and its hold fitted: two constants end at another
/// force than the recording, and the hold begins there. Slips are added one after the other, as
/// long as Akaike's criterion of the hold says so; the relaxation is fitted again beside each.
MechanicalModel MechanicalFitter::WithHoldOf(const MechanicalModel& model) const {
  std::vector<double> predicted(samples_.all.size());
  std::vector<SeriesParameter> parameters = shared_.definition;
  for (std::size_t k = 0; k < kNumShared; ++k) {
    SeriesParameter& p = parameters[k];
    p.start = std::clamp(shared_.parameters[k], p.low, p.high);
    if (k == kBuildupIn || k == kBuildupOut) p.low = p.high = p.start;
  }
  const auto fitted = [&](MechanicalModel start) {
    SharedFit fit(samples_, std::move(start));
    const std::vector<double> p =
        has_hold_ ? fit.Run(parameters, false).parameters : shared_.parameters;
    fit.Predict(p, predicted);
    return fit.model();
  };
  MechanicalModel bare = model;
  bare.slips.clear();
  MechanicalModel best = fitted(bare);
  for (int slips = 1; has_hold_ && slips <= kMostSlips; ++slips) {
    const std::vector<double> before = predicted;
    const std::optional<Slip> slip = BestSlip(samples_, best, before);
    if (!slip) break;
    MechanicalModel with = best;
    with.slips.push_back(*slip);
    for (int round = 0; round < kShareRounds; ++round) {
      with = fitted(std::move(with));
      double& share = with.slips.back().share;
      const double more = ShareMissing(samples_, with, predicted, slip->after_s);
      share = std::clamp(1.0 - (1.0 - share) * (1.0 - more), 0.0, 0.99);
    }
    with = fitted(std::move(with));
    const double independent = IndependentInHold(samples_, predicted);
    const bool is_better = HoldCriterion(samples_, predicted, independent, 2.0) <
                           HoldCriterion(samples_, before, independent, 0.0);
    if (!is_better) break;
    best = std::move(with);
  }
  std::ranges::sort(best.slips, {}, &Slip::after_s);
  return best;
}

void MechanicalFitter::FindEvents() {
  MechanicalModel& model = fit_.eventful;
  const double step_s = kEventStepMm / std::max(0.1, phases_.advance_mm_per_s);
  fit_.punctures =
      FindInternalPunctures(PhaseRows(model, curve_, phases_, true, step_s),
                            {std::max(kLeastEventN, phases_.least_drop_n), 16}, model.in);
  for (const FoundPuncture& found : fit_.punctures) model.punctures.push_back(found.law);
  if (!has_out_) return;
  fit_.releases = FindReleases(PhaseRows(model, curve_, phases_, false, step_s),
                               {std::max(kLeastEventN, phases_.least_drop_n), 8}, model.out);
  for (const FoundRelease& found : fit_.releases) model.releases.push_back(found.law);
}

void MechanicalFitter::Judge() {
  fit_.converged = shared_.converged;
  fit_.message = shared_.converged ? "" : shared_.message;
  fit_.line = {LineRms(curve_, phases_.advance), 0.0, LineRms(curve_, phases_.retract)};
  fit_.constant_rms = ReplayRms(fit_.constant, curve_, phases_);
  fit_.eventful_rms = ReplayRms(fit_.eventful, curve_, phases_);
  AddEstimates(samples_, shared_, fit_);
  for (const auto& [name, estimate] : fit_.estimates) {
    if (estimate.at_bound)
      fit_.warnings.push_back(
          name + ": 0 is the nearest value that it can have; the interval is one-sided");
  }
  for (const std::string& name : fit_.undetermined) {
    fit_.warnings.push_back(name + ": the recording does not determine it");
  }
}

}  // namespace

double OriginMm(const ForceCurve& curve, const PunctureCurveFit& puncture) {
  const SampleRange& advance = puncture.phases.advance;
  const double begin_mm = curve.depth_mm[advance.begin];
  if (puncture.starts_in_tissue || advance.size() == 0) return begin_mm;
  // The fitted puncture may be far behind the surface: that is where a force appears at all.
  double first_mm = FirstForceMm(curve, puncture);
  if (puncture.contact_depth_mm) {
    first_mm = std::min(puncture.contact_depth_mm->value, first_mm);
  }
  const double last_mm = curve.depth_mm[advance.end - 1] - kShortestMm;
  return std::clamp(first_mm, begin_mm, std::max(begin_mm, last_mm));
}

std::vector<double> ReplayPhases(const MechanicalModel& model, const ForceCurve& curve,
                                 const CurvePhases& phases) {
  const std::size_t begin = phases.advance.begin;
  const std::size_t end = std::max(HoldRange(phases).end, phases.retract.end);
  return Replay(model, std::span(curve.time_s).subspan(begin, end - begin),
                std::span(curve.depth_mm).subspan(begin, end - begin));
}

PhaseRms ReplayRms(const MechanicalModel& model, const ForceCurve& curve,
                   const CurvePhases& phases) {
  const std::vector<double> force = ReplayPhases(model, curve, phases);
  const auto rms = [&](const SampleRange& range) {
    double squares = 0.0;
    for (std::size_t i = range.begin; i < range.end; ++i) {
      const double left = force[i - phases.advance.begin] - curve.force_n[i];
      squares += left * left;
    }
    return range.size() > 0 ? std::sqrt(squares / static_cast<double>(range.size())) : 0.0;
  };
  return {rms(phases.advance), rms(HoldRange(phases)), rms(phases.retract)};
}

MechanicalFit FitMechanical(const ForceCurve& curve, const PunctureCurveFit& puncture,
                            const MechanicalOptions& options) {
  return MechanicalFitter(curve, puncture).Run(options);
}

}  // namespace acus::fitting
