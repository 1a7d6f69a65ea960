#include "acus/physics/forces/laws/shaft_friction.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {

TipGrip::TipGrip(const ForceTable& table) {
  for (std::size_t i = 0; i < n_per_mm_.size(); ++i) {
    n_per_mm_[i] = table.tissue[i].withdrawal_tip_n / kTipMm;
    grips_ |= n_per_mm_[i] > 0.0;
  }
}

ShaftFriction::ShaftFriction(const ForceTable& table)
    : settings_(table.friction_time),
      grip_(table),
      buildup_mm_(table.settings.friction_buildup_mm),
      num_laws_(table.num_times),
      law_of_(table.time_of) {
  const double rate_per_s = settings_.reference_mm_per_s / buildup_mm_;  // Of the strain.
  for (int i = 0; i < num_laws_; ++i) {
    Law& law = law_[i];
    law.time = table.times[i];
    const ForceRelaxation& relaxation = law.time.relaxation;
    law.steady = relaxation.ElasticShare();
    for (int k = 0; k < relaxation.num_terms; ++k) {
      law.steady += relaxation.share[k] * std::min(1.0, rate_per_s * relaxation.time_s[k]);
    }
    limits_vary_ |= law.time.friction_rate > 0.0 || law.time.friction_dwell > 0.0;
  }
}

void ShaftFriction::Slide(ShaftFrictionState& state, double travel_mm, double dt_s) const noexcept {
  const double moved_mm = MovedMm(state, travel_mm);
  const int pieces = limits_vary_ ? PiecesOf(settings_, moved_mm, dt_s) : 1;
  const double piece_s = dt_s / pieces;
  const double moved = moved_mm / pieces;
  const double strained = travel_mm / pieces / buildup_mm_;
  for (int piece = 0; piece < pieces; ++piece) {
    PaceLogs logs;
    if (limits_vary_) logs = AdvancePace(state, settings_, {moved, moved, piece_s});
    for (int i = 0; i < num_laws_; ++i) {
      const double limit = FrictionShare(law_[i].time, logs);
      const ForceRelaxation& relaxation = law_[i].time.relaxation;
      for (int k = 0; k <= relaxation.num_terms; ++k) {
        const double decay = k > 0 ? piece_s / relaxation.time_s[k - 1] : 0.0;
        state.strain[i][k] = StrainAfter(state.strain[i][k], strained, decay, limit);
      }
    }
  }
}

double ShaftFriction::ForceN(const ShaftFrictionState& state, const NeedlePath& path,
                             double depth_mm) const noexcept {
  std::array<double, ForceTable::kMostTimes> in{};
  std::array<double, ForceTable::kMostTimes> out{};
  for (int i = 0; i < num_laws_; ++i) {
    const ForceRelaxation& relaxation = law_[i].time.relaxation;
    for (int k = 0; k <= relaxation.num_terms; ++k) {
      const double share = k > 0 ? relaxation.share[k - 1] : relaxation.ElasticShare();
      const double s = state.strain[i][k];
      // Each sign has its own spring of bristles, and both begin at 0: no energy comes of it.
      (s > 0.0 ? in : out)[i] += share * s / law_[i].steady;
    }
  }
  const double shaft_n = path.SumN(depth_mm, [&](const NeedlePath::Segment& segment) {
    const std::uint8_t law = law_of_[segment.tissue];
    return in[law] * segment.friction_n_per_mm + out[law] * segment.withdrawal_n_per_mm;
  });
  return shaft_n +
         grip_.SumN(path, depth_mm, [&](volume::Label tissue) { return out[law_of_[tissue]]; });
}

}  // namespace acus::forces
