#include "acus/patient/fitting/shared_fit.h"

#include <algorithm>
#include <cmath>

#include "acus/base/math/statistics.h"
#include "acus/patient/fitting/depth_bins.h"

namespace acus::fitting {
namespace {

void Append(const ForceCurve& from, ForceCurve& to) {
  to.time_s.insert(to.time_s.end(), from.time_s.begin(), from.time_s.end());
  to.depth_mm.insert(to.depth_mm.end(), from.depth_mm.begin(), from.depth_mm.end());
  to.force_n.insert(to.force_n.end(), from.force_n.begin(), from.force_n.end());
}

}  // namespace

void SetShared(std::span<const double> p, MechanicalModel& model) {
  model.buildup_in_mm = std::exp(p[kBuildupIn]);
  model.buildup_out_mm = std::exp(p[kBuildupOut]);
  const double first = p[kFirstShare];
  const double second = (1.0 - first) * p[kSecondShare];
  model.relaxing_share = {first, second, (1.0 - first - second) * p[kThirdShare]};
  const double second_log = p[kLogTau] + p[kLogRatio];
  model.relaxation_s = {std::exp(p[kLogTau]), std::exp(second_log),
                        std::exp(second_log + p[kThirdLogRatio])};
}

std::vector<SeriesParameter> SharedParameters(bool has_hold, bool has_out, int branches) {
  const auto if_any = [](bool there, const char* name, double start, double low, double high) {
    return there ? SeriesParameter{name, start, low, high}
                 : SeriesParameter{name, start, start, start};
  };
  const bool two = has_hold && branches >= 2;
  const bool three = has_hold && branches >= 3;
  return {
      if_any(true, "buildup_in_mm", std::log(1.0), std::log(0.05), std::log(3.0)),
      if_any(has_out, "buildup_out_mm", std::log(0.7), std::log(0.05), std::log(3.0)),
      if_any(has_hold, "relaxing_share_1", has_hold ? 0.3 : 0.0, 0.0, 0.98),
      if_any(two, "relaxing_share_2", two ? 0.3 : 0.0, 0.0, 0.98),
      if_any(has_hold, "relaxation_1_s", std::log(three ? 0.2 : 0.7), std::log(three ? 0.02 : 0.1),
             std::log(10.0)),
      if_any(two, "relaxation_2_s", std::log(three ? 8.0 : 15.0), std::log(4.0), std::log(400.0)),
      if_any(three, "relaxing_share_3", three ? 0.3 : 0.0, 0.0, 0.98),
      if_any(three, "relaxation_3_s", std::log(10.0), std::log(4.0), std::log(400.0))};
}

PhaseSamples ThinPhases(const ForceCurve& curve, const CurvePhases& phases,
                        const MechanicalModel& model, double step_s) {
  PhaseSamples samples;
  const auto add = [&](const SampleRange& range) {
    const std::size_t begin = samples.all.size();
    Append(Thinned(curve, range, step_s), samples.all);
    return SampleRange{begin, samples.all.size()};
  };
  samples.in = add(phases.advance);
  samples.hold = add(HoldRange(phases));
  samples.out = add(phases.retract);
  for (std::size_t i = 0; i < samples.all.size(); ++i) {
    samples.all.force_n[i] -=
        model.offset_n + model.drift_n_per_s * (samples.all.time_s[i] - model.start_s);
  }
  return samples;
}

std::vector<ContactStrain> Strains(const MechanicalModel& model, const ForceCurve& curve) {
  MechanicalState state;
  std::vector<ContactStrain> strain(curve.size());
  for (std::size_t i = 0; i < curve.size(); ++i) {
    strain[i] = state.Advance(model, curve.time_s[i], curve.depth_mm[i]);
  }
  return strain;
}

StrainedRows RowsOf(const ForceCurve& samples, const std::vector<ContactStrain>& strain,
                    const SampleRange& range, bool inwards, double surface_mm) {
  StrainedRows rows;
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const double along = inwards ? strain[i].in : strain[i].out;
    const double against = inwards ? strain[i].out : strain[i].in;
    if (along == 0.0 || against != 0.0 || samples.depth_mm[i] <= surface_mm) continue;
    rows.depth_mm.push_back(samples.depth_mm[i]);
    rows.force_n.push_back(samples.force_n[i]);
    rows.strain.push_back(along);
  }
  return rows;
}

StrainedRows PhaseRows(const MechanicalModel& model, const ForceCurve& curve,
                       const CurvePhases& phases, bool inwards, double step_s) {
  const PhaseSamples samples = ThinPhases(curve, phases, model, step_s);
  return RowsOf(samples.all, Strains(model, samples.all), inwards ? samples.in : samples.out,
                inwards, model.surface_mm);
}

SharedFit::SharedFit(const PhaseSamples& samples, MechanicalModel start)
    : samples_(samples), model_(std::move(start)) {
  for (const SampleRange& range : {samples.in, samples.hold, samples.out}) {
    const double each = range.size() > 0 ? 1.0 / static_cast<double>(range.size()) : 0.0;
    weight_.insert(weight_.end(), range.size(), each);
  }
}

void SharedFit::Predict(std::span<const double> p, std::span<double> predicted) {
  SetShared(p, model_);
  const std::vector<ContactStrain> strain = Strains(model_, samples_.all);
  FitProfiles(strain);
  MechanicalState at;
  at.deepest_mm = samples_.all.depth_mm.empty() ? 0.0 : samples_.all.depth_mm[0];
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    const double depth = samples_.all.depth_mm[i];
    at.deepest_mm = std::max(at.deepest_mm, depth);
    predicted[i] = at.ForceN(model_, strain[i], depth);
  }
}

SeriesFit SharedFit::Run(const std::vector<SeriesParameter>& parameters,
                         bool weight_is_information) {
  const SeriesModel model = [this](std::span<const double> p, std::span<double> predicted) {
    Predict(p, predicted);
  };
  SeriesFit fit = FitSeries(
      model, samples_.all.force_n, parameters,
      {.weight = weight_, .weight_is_information = weight_is_information, .most_iterations = 40});
  std::vector<double> last(samples_.all.size());
  Predict(fit.parameters, last);  // Leaves the profiles of the solution in the model.
  return fit;
}

void SharedFit::WeighByResidual(std::span<const double> p) {
  std::vector<double> residual(samples_.all.size());
  Predict(p, residual);
  for (std::size_t i = 0; i < residual.size(); ++i) residual[i] -= samples_.all.force_n[i];
  for (const SampleRange& range : {samples_.in, samples_.hold, samples_.out}) {
    if (range.size() < 10) continue;
    const std::span<const double> part(residual.data() + range.begin, range.size());
    const double rms = math::RootMeanSquare(part);
    const double information = 1.0 / (std::max(rms * rms, 1e-8) * Inflation(part));
    std::fill_n(weight_.begin() + static_cast<std::ptrdiff_t>(range.begin), range.size(),
                information);
  }
}

void SharedFit::FitProfiles(const std::vector<ContactStrain>& strain) {
  FitOne(RowsOf(samples_.all, strain, samples_.in, true, model_.surface_mm), model_.in);
  const StrainedRows out = RowsOf(samples_.all, strain, samples_.out, false, model_.surface_mm);
  if (out.depth_mm.size() > 10) {
    FitOne(out, model_.out);
  } else {
    model_.out = model_.in;
  }
}

void SharedFit::FitOne(const StrainedRows& rows, ResistanceProfile& profile) const {
  std::vector<double> events(rows.depth_mm.size(), 0.0);
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (&profile == &model_.in) {
      for (const InternalPuncture& p : model_.punctures) events[i] += p.ForceN(rows.depth_mm[i]);
    } else {
      for (const Release& r : model_.releases) events[i] += r.ForceN(rows.depth_mm[i]);
    }
  }
  FitProfile(rows, events, profile);
}

SampleRange HoldRange(const CurvePhases& phases) {
  const std::size_t end = phases.retract.size() > 0 ? phases.retract.begin : phases.hold.end;
  return {phases.advance.end, std::max(phases.advance.end, end)};
}

}  // namespace acus::fitting
