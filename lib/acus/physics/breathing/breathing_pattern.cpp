#include "acus/physics/breathing/breathing_pattern.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::breathing {
namespace {

constexpr double kDayS = 24.0 * 3600.0;

/// Normal, but without the tails that would turn a breath inside out.
double Spread(RandomStream& random, double deviation) {
  return deviation * std::clamp(random.Normal(), -2.5, 2.5);
}

void Check(const PatternSettings& s) {
  ACUS_REQUIRE(s.period_s >= 0.5 && s.period_s <= 60.0, "breathing: period ", s.period_s,
               " s; allowed is 0.5 to 60");
  ACUS_REQUIRE(s.exponent >= 1 && s.exponent <= 8, "breathing: exponent ", s.exponent,
               "; allowed is 1 to 8");
  ACUS_REQUIRE(s.period_spread >= 0.0 && s.period_spread <= 0.3, "breathing: spread of periods ",
               s.period_spread, "; allowed is 0 to 0.3");
  ACUS_REQUIRE(s.speed_spread >= 0.0 && s.speed_spread <= 0.8, "breathing: spread of speed ",
               s.speed_spread, "; allowed is 0 to 0.8");
  ACUS_REQUIRE(s.level_spread >= 0.0 && s.level_spread <= 0.3, "breathing: spread of levels ",
               s.level_spread, "; allowed is 0 to 0.3");
  ACUS_REQUIRE(s.level >= 0.0 && s.level <= 5.0, "breathing: level ", s.level,
               "; allowed is 0 to 5");
}

}  // namespace

BreathingPattern::BreathingPattern(const PatternSettings& settings) : settings_(settings) {
  Check(settings);
  const bool regular =
      settings.period_spread == 0.0 && settings.speed_spread == 0.0 && settings.level_spread == 0.0;
  double start_s = 0.0;
  for (std::uint64_t n = 0; start_s <= kDayS; ++n) {
    RandomStream random(settings.seed, "breath", n);
    cycles_.push_back({.start_s = start_s,
                       .speed_change = settings.speed_spread * random.Uniform(-1.0, 1.0),
                       .high = settings.level + Spread(random, settings.level_spread),
                       .low = Spread(random, settings.level_spread)});
    const double period_s =
        regular ? settings.period_s
                : settings.period_s * (1.0 + Spread(random, settings.period_spread));
    start_s += period_s;
  }
}

Breath BreathingPattern::At(double time_s) const noexcept {
  // Written so that NaN is before all time.
  if (!(time_s > 0.0)) return {.level = cycles_.front().high};
  const auto next = std::ranges::upper_bound(cycles_, time_s, {}, &Cycle::start_s);
  if (next == cycles_.end()) return {.level = cycles_.back().high};
  const Cycle& cycle = *(next - 1);
  const double period_s = next->start_s - cycle.start_s;
  const double share = (time_s - cycle.start_s) / period_s;

  // One sine over the cycle, whose derivative is even at both ends and has no step.
  constexpr double kTwoPi = 2.0 * std::numbers::pi;
  const double change = cycle.speed_change / kTwoPi;
  Breath out;
  out.cycle = std::clamp(share + change * (1.0 - std::cos(kTwoPi * share)), 0.0, 1.0);
  const double cycle_per_s = (1.0 + kTwoPi * change * std::sin(kTwoPi * share)) / period_s;

  const double cosine = std::cos(std::numbers::pi * out.cycle);
  const double sine = std::sin(std::numbers::pi * out.cycle);
  const int power = 2 * settings_.exponent;
  const double high = out.cycle < 0.5 ? cycle.high : next->high;
  const double bell = std::pow(cosine * cosine, settings_.exponent);
  const double bell_slope = -std::numbers::pi * power * std::pow(std::abs(cosine), power - 1) *
                            (cosine < 0.0 ? -1.0 : 1.0) * sine;
  out.level = cycle.low + (high - cycle.low) * bell;
  out.level_per_s = (high - cycle.low) * bell_slope * cycle_per_s;
  if (out.cycle >= 1.0) out.cycle = 0.0;
  return out;
}

}  // namespace acus::breathing
