#include "acus/physics/forces/shaft_friction.h"

#include <algorithm>
#include <cmath>

namespace acus::forces {
namespace {

constexpr double kShaftPlayMm = 0.005;   // Jitter of an encoder: neither speed nor slip.
constexpr double kSpeedFilterS = 0.020;  // An encoder's steps look like short bursts.
constexpr double kLongestPieceS = 0.005;
constexpr double kLongestPieceOfSlip = 0.25;
constexpr double kMostPieces = 64.0;

/// Filters the speed and ages the contact over one piece; the logarithms are of its middle.
struct Pace {
  double rate_log = 0.0;
  double dwell_log = 0.0;
};
Pace AdvancePace(ShaftFrictionState& state, const FrictionTime& settings, double moved_mm,
                 double dt_s) noexcept {
  const double speed = moved_mm / dt_s;
  const double speed_before = state.speed_mm_per_s;
  state.speed_mm_per_s = speed + (speed_before - speed) * std::exp(-dt_s / kSpeedFilterS);
  const double age_before_s = state.age_s;
  const double slid = std::abs(moved_mm) / settings.slip_mm;
  const double kept_s = slid > 0.0 ? dt_s * -std::expm1(-slid) / slid : dt_s;
  state.age_s = age_before_s * std::exp(-slid) + kept_s;
  return {settings.RateLog(0.5 * (speed_before + state.speed_mm_per_s)),
          settings.DwellLog(0.5 * (age_before_s + state.age_s))};
}

/// A bristle after one piece. @param decay  1 / tau times the piece's duration.
double Strained(double strain, double strained, double decay, double limit) noexcept {
  // Where the limit has fallen below the strain, sliding takes the rest off, not the moment.
  const double faded = std::exp(-std::abs(strained));
  const double above = limit + std::max(0.0, strain - limit) * faded;
  const double below = limit + std::max(0.0, -strain - limit) * faded;
  const double free = decay > 0.0
                          ? strained / decay + (strain - strained / decay) * std::exp(-decay)
                          : strain + strained;
  return std::clamp(free, -below, above);
}

}  // namespace

ShaftFriction::ShaftFriction(const ForceTable& table)
    : settings_(table.friction_time),
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

double ShaftFriction::LimitOf(const Law& law, double rate_log, double dwell_log) const noexcept {
  return 1.0 + law.time.friction_rate * rate_log + law.time.friction_dwell * dwell_log;
}

void ShaftFriction::Slide(ShaftFrictionState& state, double travel_mm, double dt_s) const noexcept {
  const double ahead_mm = state.ahead_mm + travel_mm;
  state.ahead_mm = std::clamp(ahead_mm, -kShaftPlayMm, kShaftPlayMm);
  const double moved_mm = ahead_mm - state.ahead_mm;
  double pieces = 1.0;
  if (limits_vary_ && moved_mm != 0.0) {
    pieces = std::ceil(std::max(dt_s / kLongestPieceS,
                                std::abs(moved_mm) / (kLongestPieceOfSlip * settings_.slip_mm)));
    pieces = std::clamp(pieces, 1.0, kMostPieces);
  }
  const double piece_s = dt_s / pieces;
  const double strained = travel_mm / pieces / buildup_mm_;
  for (int piece = 0; piece < static_cast<int>(pieces); ++piece) {
    Pace pace;
    if (limits_vary_) pace = AdvancePace(state, settings_, moved_mm / pieces, piece_s);
    for (int i = 0; i < num_laws_; ++i) {
      const double limit = LimitOf(law_[i], pace.rate_log, pace.dwell_log);
      const ForceRelaxation& relaxation = law_[i].time.relaxation;
      for (int k = 0; k <= relaxation.num_terms; ++k) {
        const double decay = k > 0 ? piece_s / relaxation.time_s[k - 1] : 0.0;
        state.strain[i][k] = Strained(state.strain[i][k], strained, decay, limit);
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
  return path.SumN(depth_mm, [&](const NeedlePath::Segment& segment) {
    const std::uint8_t law = law_of_[segment.tissue];
    return in[law] * segment.friction_n_per_mm + out[law] * segment.withdrawal_n_per_mm;
  });
}

}  // namespace acus::forces
