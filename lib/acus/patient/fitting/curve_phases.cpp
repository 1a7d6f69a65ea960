#include "acus/patient/fitting/curve_phases.h"

#include <algorithm>
#include <cmath>

#include "acus/base/math/statistics.h"

namespace acus::fitting {
namespace {

constexpr double kSpeedWindowS = 0.025;  // Half width over which the drive's speed is taken.
constexpr double kSmoothingMm = 0.1;     // Travel over which the force is averaged to find peaks.
constexpr double kDropWithinMm = 3.0;    // A puncture's fall is over after this much travel.
constexpr double kSmallestDropN = 0.03;  // Below it a fall is not called a puncture.
constexpr double kNoiseDeviations =
    10.0;  // Of the smoothed noise; peak to peak it is 9 in 10^5 samples.

std::vector<double> Speed(const ForceCurve& curve, std::size_t half) {
  const std::size_t n = curve.size();
  std::vector<double> speed(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t a = i > half ? i - half : 0;
    const std::size_t b = std::min(n - 1, i + half);
    speed[i] = (curve.depth_mm[b] - curve.depth_mm[a]) / (curve.time_s[b] - curve.time_s[a]);
  }
  return speed;
}

/// Centred mean over 2 half + 1 samples, fewer at the ends.
std::vector<double> RunningMean(const std::vector<double>& values, std::size_t half) {
  const std::size_t n = values.size();
  std::vector<double> sum(n + 1, 0.0);
  for (std::size_t i = 0; i < n; ++i) sum[i + 1] = sum[i] + values[i];
  std::vector<double> mean(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t reach = std::min({half, i, n - 1 - i});
    mean[i] = (sum[i + reach + 1] - sum[i - reach]) / static_cast<double>(2 * reach + 1);
  }
  return mean;
}

void SplitByMotion(const ForceCurve& curve, CurvePhases& phases) {
  const std::size_t n = curve.size();
  const double dt_s = (curve.time_s.back() - curve.time_s.front()) / static_cast<double>(n - 1);
  phases.rate_hz = 1.0 / dt_s;
  const auto half = std::max<std::size_t>(1, static_cast<std::size_t>(kSpeedWindowS / dt_s));
  const std::vector<double> speed = Speed(curve, half);
  const auto deepest =
      static_cast<std::size_t>(std::ranges::max_element(curve.depth_mm) - curve.depth_mm.begin());
  std::vector<double> forward;
  for (std::size_t i = 0; i <= deepest; ++i) {
    if (speed[i] > 0.0) forward.push_back(speed[i]);
  }
  phases.moving_in.assign(n, false);
  if (forward.empty()) return;
  // The drive's speed is that of the fast half of its motion: rests and creep do not count.
  const double top = math::Quantile(forward, 0.9);
  std::erase_if(forward, [top](double v) { return v < 0.5 * top; });
  phases.advance_mm_per_s = math::Median(forward);
  const auto is_rest = [&](std::size_t i) { return std::abs(speed[i]) < 0.02 * top; };

  std::size_t begin = 0;
  while (begin < deepest && is_rest(begin)) ++begin;
  phases.rest = {0, begin > half ? begin - half : 0};
  std::size_t last_in = deepest;
  while (last_in > begin && speed[last_in] < 0.5 * top) --last_in;
  phases.advance = {begin, last_in + 1};
  std::size_t first_out = deepest;
  while (first_out < n && speed[first_out] > -0.1 * top) ++first_out;
  phases.hold = {std::min(last_in + 1 + half, first_out), first_out > half ? first_out - half : 0};
  std::size_t last_out = n - 1;
  while (last_out > first_out && speed[last_out] > -0.1 * top) --last_out;
  phases.retract = {first_out, first_out < n ? last_out + 1 : n};
  for (std::size_t i = begin; i <= last_in; ++i) phases.moving_in[i] = speed[i] > 0.8 * top;
}

/// Where the raw force jumps down most between the means of `width` samples on either side.
PunctureEvent Sharpened(const ForceCurve& curve, const CurvePhases& phases, std::size_t from,
                        std::size_t to, PunctureEvent event) {
  const std::size_t width = std::max<std::size_t>(3, phases.smoothing / 2);
  double largest = 0.0;
  std::size_t where = event.peak;
  for (std::size_t k = std::max(from, width); k <= to && k + width < curve.size(); ++k) {
    double before = 0.0;
    double after = 0.0;
    for (std::size_t j = 0; j < width; ++j) {
      before += curve.force_n[k - j];
      after += curve.force_n[k + 1 + j];
    }
    const double jump = (before - after) / static_cast<double>(width);
    if (jump > largest) {
      largest = jump;
      where = k;
    }
  }
  if (largest < 0.7 * event.drop_n) return event;
  event.sharp = true;
  event.peak = where;
  event.trough = where + 1;
  return event;
}

void FindPunctures(const ForceCurve& curve, CurvePhases& phases) {
  const SampleRange advance = phases.advance;
  const std::vector<double>& smooth = phases.smooth_n;
  std::size_t top = advance.begin;
  for (std::size_t i = advance.begin; i < advance.end; ++i) {
    if (smooth[i] > smooth[top]) top = i;
    if (smooth[top] - smooth[i] < phases.least_drop_n) continue;
    // A fall is certain. It ends where 90 % of what comes within kDropWithinMm of the peak is done.
    std::size_t low = top;
    std::size_t j = top;
    for (; j < advance.end && curve.depth_mm[j] - curve.depth_mm[top] <= kDropWithinMm; ++j) {
      if (smooth[j] < smooth[low]) low = j;
      if (smooth[j] > smooth[low] + phases.least_drop_n && low > top) break;
    }
    const double drop = smooth[top] - smooth[low];
    // A drive that slows down takes the force with it: that is no puncture.
    if (drop >= phases.least_drop_n && phases.moving_in[top] && phases.moving_in[low]) {
      std::size_t done = top;
      while (done < low && smooth[top] - smooth[done] < 0.9 * drop) ++done;
      const std::size_t reach = 2 * phases.smoothing;
      phases.punctures.push_back(Sharpened(curve, phases, top > reach ? top - reach : 0,
                                           done + reach, {top, done, drop, false}));
      i = std::max(i, low);
    }
    top = i;
  }
}

}  // namespace

CurvePhases FindPhases(const ForceCurve& curve) {
  CurvePhases phases;
  phases.smooth_n = curve.force_n;
  if (curve.size() < 3) return phases;
  SplitByMotion(curve, phases);
  std::vector<double> difference(curve.size() - 1);
  for (std::size_t i = 0; i + 1 < curve.size(); ++i) {
    difference[i] = curve.force_n[i + 1] - curve.force_n[i];
  }
  phases.noise_n = math::RobustDeviation(difference) / std::sqrt(2.0);
  const double samples_per_mm =
      phases.advance_mm_per_s > 0.0 ? phases.rate_hz / phases.advance_mm_per_s : 1.0;
  const auto half =
      static_cast<std::size_t>(std::max(1.0, std::min(0.5 * kSmoothingMm * samples_per_mm,
                                                      0.01 * static_cast<double>(curve.size()))));
  phases.smoothing = 2 * half + 1;
  phases.smooth_n = RunningMean(curve.force_n, half);
  phases.least_drop_n =
      std::max(kSmallestDropN, kNoiseDeviations * phases.noise_n /
                                   std::sqrt(static_cast<double>(phases.smoothing)));
  FindPunctures(curve, phases);
  return phases;
}

}  // namespace acus::fitting
