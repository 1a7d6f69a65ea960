#include "acus/patient/fitting/hold_slips.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace acus::fitting {
namespace {

constexpr double kLeastShare = 0.03;
constexpr double kLeastSlipN = 0.03;
constexpr double kEdgeS = 0.5;  // Slips nearer to the begin of the rest are relaxation.

std::vector<double> LeftInHold(const PhaseSamples& samples, std::span<const double> predicted) {
  std::vector<double> left;
  for (std::size_t i = samples.hold.begin; i < samples.hold.end; ++i) {
    left.push_back(predicted[i] - samples.all.force_n[i]);
  }
  return left;
}

/// Time at rest by sample of the hold.
std::vector<double> RestedS(const PhaseSamples& samples, const MechanicalModel& model) {
  MechanicalState state;
  std::vector<double> rested;
  for (std::size_t i = 0; i < samples.hold.end; ++i) {
    state.Advance(model, samples.all.time_s[i], samples.all.depth_mm[i]);
    if (i >= samples.hold.begin) rested.push_back(state.rest_s);
  }
  return rested;
}

}  // namespace

std::optional<Slip> BestSlip(const PhaseSamples& samples, const MechanicalModel& model,
                             std::span<const double> predicted) {
  const std::vector<double> left = LeftInHold(samples, predicted);
  const std::vector<double> rested = RestedS(samples, model);
  double products = 0.0;
  double squares = 0.0;
  double most = 0.0;
  std::optional<Slip> best;
  for (std::size_t i = left.size(); i-- > 1;) {
    const double m = predicted[samples.hold.begin + i];
    products += m * left[i];
    squares += m * m;
    const double share = squares > 0.0 ? products / squares : 0.0;
    const bool counts = share >= kLeastShare && share < 1.0 && share * m >= kLeastSlipN &&
                        rested[i] > kEdgeS && rested[i - 1] > 0.0;
    if (!counts || products * share <= most) continue;
    most = products * share;
    best = Slip{0.5 * (rested[i - 1] + rested[i]), share};
  }
  return best;
}

double IndependentInHold(const PhaseSamples& samples, std::span<const double> predicted) {
  const std::vector<double> left = LeftInHold(samples, predicted);
  return static_cast<double>(left.size()) / Inflation(left);
}

double HoldCriterion(const PhaseSamples& samples, std::span<const double> predicted,
                     double independent, double parameters) {
  double squares = 1e-30;
  for (const double l : LeftInHold(samples, predicted)) squares += l * l;
  return independent * std::log(squares) + 2.0 * parameters;
}

}  // namespace acus::fitting
