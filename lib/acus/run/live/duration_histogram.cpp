#include "acus/run/live/duration_histogram.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace acus::live {

void DurationHistogram::Add(std::int64_t duration_ns) noexcept {
  const double octaves = std::log2(std::max(1.0, static_cast<double>(duration_ns) / kSmallestNs));
  const int bin = std::clamp(static_cast<int>(octaves * kBinsPerOctave), 0, kNumBins - 1);
  bins_[static_cast<std::size_t>(bin)].fetch_add(1, std::memory_order_relaxed);
  if (duration_ns > max_ns()) max_ns_.store(duration_ns, std::memory_order_relaxed);
}

std::int64_t DurationHistogram::count() const noexcept {
  std::int64_t sum = 0;
  for (const auto& bin : bins_) sum += bin.load(std::memory_order_relaxed);
  return sum;
}

double DurationHistogram::QuantileNs(double share) const noexcept {
  const std::int64_t total = count();
  if (total == 0) return 0.0;
  const auto wanted = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::ceil(share * static_cast<double>(total))));
  std::int64_t sum = 0;
  int bin = 0;
  for (; bin < kNumBins - 1; ++bin) {
    sum += bins_[static_cast<std::size_t>(bin)].load(std::memory_order_relaxed);
    if (sum >= wanted) break;
  }
  const double edge_ns = kSmallestNs * std::exp2((bin + 1.0) / kBinsPerOctave);
  return std::min(edge_ns, static_cast<double>(max_ns()));
}

nlohmann::json DurationHistogram::ToJson() const {
  const auto ms = [this](double share) { return 1e-6 * QuantileNs(share); };
  return {{"count", count()},
          {"median_ms", ms(0.5)},
          {"p99_ms", ms(0.99)},
          {"p99_9_ms", ms(0.999)},
          {"max_ms", 1e-6 * static_cast<double>(max_ns())}};
}

}  // namespace acus::live
