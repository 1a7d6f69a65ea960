// The rate of an event over the last seconds, so that an indicator drops faults that have passed.
#pragma once

#include <cstdint>
#include <deque>

namespace acus::live {

/// Differences of a count that only grows, over the last seconds.
class RecentRate {
 public:
  explicit RecentRate(double window_s) : window_ns_(static_cast<std::int64_t>(1e9 * window_s)) {}

  /// @param count  Total so far.
  void Add(std::int64_t now_ns, std::int64_t count) {
    points_.push_back({now_ns, count});
    while (points_.size() > 2 && now_ns - points_[1].time_ns >= window_ns_) points_.pop_front();
  }
  /// The increase within the window.
  std::int64_t recent() const {
    return points_.empty() ? 0 : points_.back().count - points_.front().count;
  }
  /// 0 before the window has been filled once: the start is not typical.
  double per_s() const {
    if (points_.size() < 2) return 0.0;
    const std::int64_t span_ns = points_.back().time_ns - points_.front().time_ns;
    return span_ns < window_ns_
               ? 0.0
               : 1e9 * static_cast<double>(recent()) / static_cast<double>(span_ns);
  }

 private:
  struct Point {
    std::int64_t time_ns;
    std::int64_t count;
  };
  std::int64_t window_ns_;
  std::deque<Point> points_;
};

}  // namespace acus::live
