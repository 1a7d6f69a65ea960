#include "acus/patient/fitting/joint_contact.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "acus/patient/fitting/depth_bins.h"
#include "acus/patient/fitting/shared_fit.h"

namespace acus::fitting {
namespace {

constexpr double kApproachStepS = 0.2;  // Of the insertion only the strain at its end matters.
constexpr double kTurnStepS = 0.02;
constexpr double kTurnMm = 4.0;   // Of the withdrawal: then it slides.
constexpr int kHoldSamples = 60;  // Evenly over the logarithm of the time.
constexpr double kFewestHoldS = 1.0;

/// The samples of one recording that depend on its contact.
struct ContactSamples {
  ForceCurve all;              ///< Force without offset and drift.
  std::vector<double> weight;  ///< Square roots; 0 during insertion.
};

void AddSamples(const ForceCurve& from, double weight, ContactSamples& to) {
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!to.all.time_s.empty() && !(from.time_s[i] > to.all.time_s.back())) continue;
    to.all.time_s.push_back(from.time_s[i]);
    to.all.depth_mm.push_back(from.depth_mm[i]);
    to.all.force_n.push_back(from.force_n[i]);
    to.weight.push_back(weight);
  }
}

/// Means over steps that grow with the time since the hold began.
ForceCurve ByLogarithm(const ForceCurve& thin, double begin_s) {
  ForceCurve chosen;
  if (thin.size() == 0) return chosen;
  const double whole_s = std::max(1.0, thin.time_s.back() - begin_s);
  std::size_t i = 0;
  for (int k = 1; k <= kHoldSamples; ++k) {
    const double until_s =
        begin_s + kTurnStepS * std::pow(whole_s / kTurnStepS, k / double{kHoldSamples});
    double time = 0.0, depth = 0.0, force = 0.0, count = 0.0;
    for (; i < thin.size() && thin.time_s[i] <= until_s; ++i) {
      time += thin.time_s[i], depth += thin.depth_mm[i], force += thin.force_n[i], count += 1.0;
    }
    if (count == 0.0) continue;
    chosen.time_s.push_back(time / count);
    chosen.depth_mm.push_back(depth / count);
    chosen.force_n.push_back(force / count);
  }
  return chosen;
}

ContactSamples ContactSamplesOf(const JointRecording& recording) {
  const ForceCurve& curve = *recording.curve;
  const CurvePhases& phases = *recording.phases;
  ContactSamples samples;
  const SampleRange hold = HoldRange(phases);
  const double end_s = curve.time_s[phases.advance.end - 1];
  if (hold.size() < 20 || curve.time_s[hold.end - 1] - end_s < kFewestHoldS) return samples;
  AddSamples(Thinned(curve, phases.advance, kApproachStepS), 0.0, samples);
  const ForceCurve held = ByLogarithm(Thinned(curve, hold, kTurnStepS), end_s);
  AddSamples(held, 1.0 / std::sqrt(static_cast<double>(std::max<std::size_t>(1, held.size()))),
             samples);
  SampleRange turn = phases.retract;
  const double from_mm = curve.depth_mm[turn.begin];
  std::size_t last = turn.begin;
  while (last < turn.end && curve.depth_mm[last] > from_mm - kTurnMm) ++last;
  turn.end = last;
  const ForceCurve turned = Thinned(curve, turn, kTurnStepS);
  AddSamples(turned, 1.0 / std::sqrt(static_cast<double>(std::max<std::size_t>(1, turned.size()))),
             samples);
  const MechanicalModel& own = recording.fit->constant;
  for (std::size_t i = 0; i < samples.all.size(); ++i) {
    samples.all.force_n[i] -=
        own.offset_n + own.drift_n_per_s * (samples.all.time_s[i] - own.start_s);
  }
  return samples;
}

int BranchesOf(const MechanicalModel& model) {
  return static_cast<int>(
      std::ranges::count_if(model.relaxing_share, [](double share) { return share > 0.0; }));
}

/// SetShared the other way round, within what is allowed.
void StartFrom(const MechanicalModel& model, std::vector<SeriesParameter>& parameters) {
  const auto& share = model.relaxing_share;
  const auto& tau_s = model.relaxation_s;
  const double start[kNumShared] = {std::log(model.buildup_in_mm),
                                    std::log(model.buildup_out_mm),
                                    share[0],
                                    share[1] / std::max(1e-9, 1.0 - share[0]),
                                    std::log(tau_s[0]),
                                    std::log(tau_s[1] / tau_s[0]),
                                    share[2] / std::max(1e-9, 1.0 - share[0] - share[1]),
                                    std::log(tau_s[2] / tau_s[1])};
  for (std::size_t k = 0; k < kNumShared; ++k) {
    parameters[k].start = std::clamp(start[k], parameters[k].low, parameters[k].high);
  }
}

}  // namespace

void FitJointContact(std::span<const JointRecording> recordings, MechanicalModel& model) {
  std::vector<ContactSamples> all;
  std::vector<double> measured;
  for (const JointRecording& recording : recordings) {
    ContactSamples samples = ContactSamplesOf(recording);
    if (samples.all.size() == 0) continue;
    for (std::size_t i = 0; i < samples.all.size(); ++i) {
      measured.push_back(samples.weight[i] * samples.all.force_n[i]);
    }
    all.push_back(std::move(samples));
  }
  const int branches = BranchesOf(model);
  if (all.empty() || branches == 0) return;
  std::vector<SeriesParameter> parameters = SharedParameters(true, true, branches);
  StartFrom(model, parameters);
  MechanicalModel trial = model;
  const SeriesModel predict = [&](std::span<const double> p, std::span<double> predicted) {
    SetShared(p, trial);
    std::size_t row = 0;
    for (const ContactSamples& samples : all) {
      MechanicalState state;
      for (std::size_t i = 0; i < samples.all.size(); ++i, ++row) {
        const double depth_mm = samples.all.depth_mm[i];
        const ContactStrain strain = state.Advance(trial, samples.all.time_s[i], depth_mm);
        predicted[row] = samples.weight[i] * state.ForceN(trial, strain, depth_mm);
      }
    }
  };
  const SeriesFit fit = FitSeries(predict, measured, parameters, {.most_iterations = 40});
  if (fit.converged) SetShared(fit.parameters, model);
}

}  // namespace acus::fitting
