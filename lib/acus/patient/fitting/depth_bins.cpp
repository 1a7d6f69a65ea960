#include "acus/patient/fitting/depth_bins.h"

#include <algorithm>
#include <cmath>

namespace acus::fitting {

DepthBins BinByDepth(const ForceCurve& curve, const SampleRange& range, double step_mm,
                     std::size_t most) {
  DepthBins bins;
  if (range.size() == 0) return bins;
  const auto first = curve.depth_mm.begin() + static_cast<std::ptrdiff_t>(range.begin);
  const auto last = curve.depth_mm.begin() + static_cast<std::ptrdiff_t>(range.end);
  const auto [low, high] = std::minmax_element(first, last);
  const double origin_mm = *low;
  const double step = std::max(step_mm, (*high - origin_mm) / static_cast<double>(most - 1));
  const auto count = static_cast<std::size_t>((*high - origin_mm) / step) + 1;
  std::vector<double> depth(count, 0.0);
  std::vector<double> force(count, 0.0);
  std::vector<double> samples(count, 0.0);
  for (std::size_t i = range.begin; i < range.end; ++i) {
    const auto k =
        std::min(count - 1, static_cast<std::size_t>((curve.depth_mm[i] - origin_mm) / step));
    depth[k] += curve.depth_mm[i];
    force[k] += curve.force_n[i];
    samples[k] += 1.0;
  }
  for (std::size_t k = 0; k < count; ++k) {
    if (samples[k] == 0.0) continue;
    bins.depth_mm.push_back(depth[k] / samples[k]);
    bins.force_n.push_back(force[k] / samples[k]);
    bins.count.push_back(samples[k]);
  }
  return bins;
}

ForceCurve Thinned(const ForceCurve& curve, const SampleRange& range, double step_s) {
  ForceCurve thin;
  thin.name = curve.name;
  for (std::size_t i = range.begin; i < range.end;) {
    const double until_s = curve.time_s[i] + step_s;
    double time = 0.0;
    double depth = 0.0;
    double force = 0.0;
    const std::size_t begin = i;
    for (; i < range.end && (i == begin || curve.time_s[i] < until_s - 1e-9); ++i) {
      time += curve.time_s[i];
      depth += curve.depth_mm[i];
      force += curve.force_n[i];
    }
    const auto n = static_cast<double>(i - begin);
    thin.time_s.push_back(time / n);
    thin.depth_mm.push_back(depth / n);
    thin.force_n.push_back(force / n);
  }
  return thin;
}

}  // namespace acus::fitting
