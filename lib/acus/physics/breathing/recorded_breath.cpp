#include "acus/physics/breathing/recorded_breath.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::breathing {
namespace {

constexpr double kFadeS = 2.0;
constexpr double kShortestBreathS = 1.0;

/// Samples beyond the ends are as the last ones, or those of the next round.
double Beyond(const std::vector<double>& values, std::ptrdiff_t n, bool round) {
  const std::ptrdiff_t last = std::ssize(values) - 1;
  if (round)
    n -= last * static_cast<std::ptrdiff_t>(
                    std::floor(static_cast<double>(n) / static_cast<double>(last)));
  return values[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(n, 0, last))];
}

/// Values and derivatives (per sample) after a Gaussian of this deviation in samples.
void Smooth(const std::vector<double>& in, double deviation, bool round, std::vector<double>& value,
            std::vector<double>& slope) {
  const auto half = static_cast<std::ptrdiff_t>(std::ceil(4.0 * deviation));
  std::vector<double> weight;
  double sum = 0.0;
  double moment = 0.0;  // So that a straight line keeps its slope exactly.
  for (std::ptrdiff_t t = -half; t <= half; ++t) {
    const double x = static_cast<double>(t) / std::max(deviation, 1e-9);
    weight.push_back(std::exp(-0.5 * x * x));
    sum += weight.back();
    moment += weight.back() * static_cast<double>(t * t);
  }
  for (std::ptrdiff_t n = 0; n < std::ssize(in); ++n) {
    double v = 0.0;
    double s = 0.0;
    for (std::ptrdiff_t t = -half; t <= half; ++t) {
      const double weighted = weight[static_cast<std::size_t>(t + half)] * Beyond(in, n + t, round);
      v += weighted;
      s += weighted * static_cast<double>(t);
    }
    value.push_back(v / sum);
    slope.push_back(s / moment);
  }
}

/// The recording's end, faded into its beginning: it can go round without a step.
void CloseLoop(std::vector<double>& level, std::size_t fade) {
  const std::size_t kept = level.size() - fade;
  for (std::size_t n = 0; n < fade; ++n) {
    const double x = static_cast<double>(n) / static_cast<double>(fade);
    const double share = x * x * (3.0 - 2.0 * x);
    level[n] = (1.0 - share) * level[kept + n] + share * level[n];
  }
  level.resize(kept);
  level.push_back(level.front());
}

}  // namespace

RecordedBreath::RecordedBreath(const BreathSignal& signal, const RecordedBreathSettings& settings)
    : step_s_(signal.step_s), repeat_(settings.repeat) {
  ACUS_REQUIRE(settings.smoothing_s > 0.0 && settings.smoothing_s <= 5.0,
               "breathing: smoothing over ", settings.smoothing_s, " s; allowed is above 0 to 5");
  std::vector<double> level = signal.level;
  const auto fade = static_cast<std::size_t>(kFadeS / step_s_);
  ACUS_REQUIRE(!repeat_ || level.size() > 3 * fade, "breathing: a recording of ",
               signal.duration_s(), " s is too short to be repeated; at least ", 3.0 * kFadeS,
               " s are needed");
  if (repeat_) CloseLoop(level, fade);
  Smooth(level, std::max(1.0, settings.smoothing_s / step_s_), repeat_, level_, level_per_s_);
  for (double& slope : level_per_s_) slope /= step_s_;
  FindBreaths();
}

void RecordedBreath::FindBreaths() {
  // A breath spans at least a third of what most of the signal spans.
  const double span = math::Quantile(level_, 0.95) - math::Quantile(level_, 0.05);
  const double swing = span / 3.0;
  const auto shortest = static_cast<std::size_t>(kShortestBreathS / step_s_);
  std::vector<double> highs;
  std::vector<double> lows;
  std::size_t high = 0;
  std::size_t low = 0;
  bool rising = true;
  for (std::size_t n = 0; n < level_.size(); ++n) {
    if (rising) {
      if (level_[n] > level_[high]) high = n;
      if (level_[high] - level_[n] > swing) {
        if (high > 0 && (peaks_.empty() || high - peaks_.back() >= shortest)) {
          peaks_.push_back(high);
          highs.push_back(level_[high]);
        }
        rising = false;
        low = n;
      }
    } else {
      if (level_[n] < level_[low]) low = n;
      if (level_[n] - level_[low] > swing) {
        lows.push_back(level_[low]);
        rising = true;
        high = n;
      }
    }
  }
  ACUS_REQUIRE(peaks_.size() >= 2 && !lows.empty(), "breathing: ", peaks_.size(),
               " inspirations in a recording of ", duration_s(),
               " s; at least two are needed. Is the sampling rate right?");
  inspiration_level_ = math::Median(highs);
  expiration_level_ = math::Median(lows);
}

double RecordedBreath::CycleAt(double sample) const noexcept {
  const auto next = std::ranges::upper_bound(
      peaks_, sample, {}, [](std::size_t peak) { return static_cast<double>(peak); });
  // Before the first and after the last inspiration, as fast as the breath beside it.
  const auto end = std::clamp(next, peaks_.begin() + 1, peaks_.end() - 1);
  const auto from = static_cast<double>(*(end - 1));
  const double cycle = (sample - from) / (static_cast<double>(*end) - from);
  return std::clamp(cycle - std::floor(cycle), 0.0, std::nextafter(1.0, 0.0));
}

Breath RecordedBreath::Normalised(const Breath& breath) const noexcept {
  const double span = inspiration_level_ - expiration_level_;
  return {.cycle = breath.cycle,
          .level = (breath.level - expiration_level_) / span,
          .level_per_s = breath.level_per_s / span};
}

Breath RecordedBreath::At(double time_s) const noexcept {
  const double last = static_cast<double>(level_.size() - 1);
  double sample = time_s / step_s_;
  if (repeat_) sample -= last * std::floor(sample / last);
  const bool outside = !(sample >= 0.0 && sample <= last);
  sample = std::min(std::max(0.0, sample), last);  // NaN: the beginning.
  const auto n = static_cast<std::size_t>(std::min(sample, last - 1.0));
  const double share = sample - static_cast<double>(n);
  Breath out;
  out.cycle = CycleAt(sample);
  out.level = level_[n] + share * (level_[n + 1] - level_[n]);
  out.level_per_s =
      outside ? 0.0 : level_per_s_[n] + share * (level_per_s_[n + 1] - level_per_s_[n]);
  return out;
}

}  // namespace acus::breathing
