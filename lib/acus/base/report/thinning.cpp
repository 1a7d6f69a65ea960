#include "acus/base/report/thinning.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <utility>

namespace acus::report {
namespace {

/// Appends what must stay of points[begin, end): the ends and the extremes of both coordinates.
void KeepOutline(const std::vector<PixelPoint>& points, std::size_t begin, std::size_t end,
                 bool both_axes, std::vector<PixelPoint>& kept) {
  std::vector<std::size_t> rows{begin, end - 1};
  const auto first = points.begin() + static_cast<std::ptrdiff_t>(begin);
  const auto last = points.begin() + static_cast<std::ptrdiff_t>(end);
  const auto keep_extremes = [&](double PixelPoint::*coordinate) {
    const auto smaller = [coordinate](const PixelPoint& a, const PixelPoint& b) {
      return a.*coordinate < b.*coordinate;
    };
    const auto [low, high] = std::minmax_element(first, last, smaller);
    rows.push_back(static_cast<std::size_t>(low - points.begin()));
    rows.push_back(static_cast<std::size_t>(high - points.begin()));
  };
  keep_extremes(&PixelPoint::y);
  if (both_axes) keep_extremes(&PixelPoint::x);
  std::ranges::sort(rows);
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  for (const std::size_t row : rows) kept.push_back(points[row]);
}

}  // namespace

std::vector<PixelPoint> ThinnedLine(const std::vector<PixelPoint>& points, int max_points) {
  const auto limit = static_cast<std::size_t>(std::max(max_points, 8));
  std::vector<PixelPoint> kept;
  for (std::size_t begin = 0; begin < points.size();) {
    const double column = std::floor(points[begin].x);
    std::size_t end = begin + 1;
    while (end < points.size() && std::floor(points[end].x) == column) ++end;
    KeepOutline(points, begin, end, /*both_axes=*/false, kept);
    begin = end;
  }
  if (kept.size() <= limit) return kept;
  // The line runs back and forth between columns: thin it along its length.
  kept.clear();
  const std::size_t runs = limit / 6;
  const std::size_t length = (points.size() + runs - 1) / runs;
  for (std::size_t begin = 0; begin < points.size(); begin += length) {
    KeepOutline(points, begin, std::min(begin + length, points.size()), /*both_axes=*/true, kept);
  }
  return kept;
}

std::vector<PixelPoint> ThinnedPoints(const std::vector<PixelPoint>& points, double cell_px,
                                      int max_points) {
  for (;; cell_px *= 1.5) {
    std::set<std::pair<std::int64_t, std::int64_t>> taken;
    std::vector<PixelPoint> kept;
    for (const PixelPoint& point : points) {
      const auto cell =
          std::make_pair(std::llround(point.x / cell_px), std::llround(point.y / cell_px));
      if (taken.insert(cell).second) kept.push_back(point);
    }
    if (kept.size() <= static_cast<std::size_t>(std::max(max_points, 1)) || cell_px > 1e6) {
      return kept;
    }
  }
}

}  // namespace acus::report
