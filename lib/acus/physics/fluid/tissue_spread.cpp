#include "acus/physics/fluid/tissue_spread.h"

#include <cmath>

namespace acus::fluid {
namespace {

/// Radius of the outermost node over that of the cavity: the spread of 1000 time constants.
constexpr double kFarthest = 30.0;
/// Growth of the shells: the outermost step over the innermost, as exp of this.
constexpr double kGrowth = 5.0;

double NodeRadius(int node, int num) noexcept {
  const double share = static_cast<double>(node) / static_cast<double>(num - 1);
  return 1.0 + (kFarthest - 1.0) * std::expm1(kGrowth * share) / std::expm1(kGrowth);
}

}  // namespace

TissueSpread::TissueSpread(double steady_kpa_s_per_ml, double time_s, int num_shells) noexcept {
  if (!(steady_kpa_s_per_ml > 0.0)) return;
  num_ = num_shells;
  // In radii of the cavity: between nodes exact for the steady 1/r, beyond the last one too.
  double inner_face = 1.0;
  for (int i = 0; i < num_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double radius = NodeRadius(i, num_);
    const bool is_last = i + 1 == num_;
    const double next = is_last ? 0.0 : NodeRadius(i + 1, num_);
    const double outer_face = is_last ? 2.0 * radius - inner_face : 0.5 * (radius + next);
    out_ml_per_kpa_s_[at] =
        1.0 / (steady_kpa_s_per_ml * (1.0 / radius - (is_last ? 0.0 : 1.0 / next)));
    storage_ml_per_kpa_[at] =
        time_s / (3.0 * steady_kpa_s_per_ml) * (std::pow(outer_face, 3) - std::pow(inner_face, 3));
    inner_face = outer_face;
  }
}

TissueSpread::Sweep TissueSpread::Eliminate(const State& state, double dt_s) const noexcept {
  // From the outermost shell inwards: to a shell, those beyond it are a conductance and a source.
  Sweep sweep;
  double conductance = num_ > 0 ? out_ml_per_kpa_s_[static_cast<std::size_t>(num_ - 1)] : 0.0;
  double source = 0.0;
  for (int i = num_ - 1; i >= 0; --i) {
    const auto at = static_cast<std::size_t>(i);
    const double stored = storage_ml_per_kpa_[at] / dt_s;
    sweep.diagonal[at] = stored + conductance;
    sweep.right[at] = stored * state.kpa[at] + source;
    if (i == 0) break;
    const double link = out_ml_per_kpa_s_[at - 1];
    const double passed = link / (link + sweep.diagonal[at]);
    conductance = passed * sweep.diagonal[at];
    source = passed * sweep.right[at];
  }
  return sweep;
}

TissueSpread::Response TissueSpread::ResponseOf(const State& state, double dt_s) const noexcept {
  if (num_ == 0) return {};
  const Sweep sweep = Eliminate(state, dt_s);
  return {sweep.right[0] / sweep.diagonal[0], 1.0 / sweep.diagonal[0]};
}

void TissueSpread::Advance(State& state, double flow_ml_per_s, double dt_s) const noexcept {
  if (num_ == 0) return;
  const Sweep sweep = Eliminate(state, dt_s);
  state.kpa[0] = (sweep.right[0] + flow_ml_per_s) / sweep.diagonal[0];
  for (int i = 1; i < num_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double link = out_ml_per_kpa_s_[at - 1];
    state.kpa[at] = (sweep.right[at] + link * state.kpa[at - 1]) / (sweep.diagonal[at] + link);
  }
}

double TissueSpread::StoredMl(const State& state) const noexcept {
  double sum_ml = 0.0;
  for (int i = 0; i < num_; ++i) {
    const auto at = static_cast<std::size_t>(i);
    sum_ml += storage_ml_per_kpa_[at] * state.kpa[at];
  }
  return sum_ml;
}

}  // namespace acus::fluid
