#include "acus/rig/tracking/clock_estimate.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace acus::tracking {

void ClockEstimate::Restart(std::int64_t offset_ns, std::int64_t arrival_ns) noexcept {
  known_ = true;
  drift_ = 0.0;
  base_time_ns_ = window_start_ns_ = smallest_time_ns_ = arrival_ns;
  base_offset_ns_ = smallest_ns_ = offset_ns;
  num_minima_ = 0;
}

void ClockEstimate::Observe(std::int64_t source_ns, std::int64_t arrival_ns) noexcept {
  const std::int64_t offset_ns = arrival_ns - source_ns;
  if (!known_) {
    Restart(offset_ns, arrival_ns);
    return;
  }
  const std::int64_t below_ns = OffsetNs(arrival_ns) - offset_ns;
  // Far late is a clock set back only if it stays: the smallest of a whole window decides (below).
  if (below_ns > kSetNs) {
    ++times_set_;
    Restart(offset_ns, arrival_ns);
    return;
  }
  // Sooner than the line allows: the line was too high.
  if (below_ns > 0) base_offset_ns_ -= below_ns;

  if (arrival_ns - window_start_ns_ >= kWindowNs) {
    const bool was_set = smallest_ns_ - OffsetNs(smallest_time_ns_) > kSetNs;
    if (was_set) {
      ++times_set_;
      Restart(offset_ns, arrival_ns);
      return;
    }
    CloseWindow();
    window_start_ns_ = smallest_time_ns_ = arrival_ns;
    smallest_ns_ = offset_ns;
  } else if (offset_ns < smallest_ns_) {
    smallest_ns_ = offset_ns;
    smallest_time_ns_ = arrival_ns;
  }
}

void ClockEstimate::CloseWindow() noexcept {
  minima_[num_minima_++ % kWindows] = {.time_ns = smallest_time_ns_, .offset_ns = smallest_ns_};
  const std::size_t count = std::min(num_minima_, kWindows);
  const Minimum first = minima_[num_minima_ > kWindows ? num_minima_ % kWindows : 0];
  double mean_t = 0.0, mean_o = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    mean_t += static_cast<double>(minima_[i].time_ns - first.time_ns) / static_cast<double>(count);
    mean_o +=
        static_cast<double>(minima_[i].offset_ns - first.offset_ns) / static_cast<double>(count);
  }
  double tt = 0.0, to = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(minima_[i].time_ns - first.time_ns) - mean_t;
    tt += t * t;
    to += t * (static_cast<double>(minima_[i].offset_ns - first.offset_ns) - mean_o);
  }
  // Over a few seconds the jitter of the delay would pass for drift; and no clock is off by 0.1 %.
  drift_ = count >= 10 && tt > 0.0 ? std::clamp(to / tt, -1e-3, 1e-3) : 0.0;
  // The highest line of this slope that no smallest offset lies below.
  base_time_ns_ = smallest_time_ns_;
  base_offset_ns_ = INT64_MAX;
  for (std::size_t i = 0; i < count; ++i) {
    const double shift = drift_ * static_cast<double>(base_time_ns_ - minima_[i].time_ns);
    base_offset_ns_ =
        std::min(base_offset_ns_, minima_[i].offset_ns + std::int64_t{std::llround(shift)});
  }
}

std::int64_t ClockEstimate::OffsetNs(std::int64_t time_ns) const noexcept {
  return base_offset_ns_ + std::llround(drift_ * static_cast<double>(time_ns - base_time_ns_));
}

std::int64_t ClockEstimate::OursNs(std::int64_t source_ns, std::int64_t arrival_ns) const noexcept {
  return std::min(arrival_ns, source_ns + OffsetNs(arrival_ns));
}

}  // namespace acus::tracking
