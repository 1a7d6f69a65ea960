#include "support/envelope_measures.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "acus/base/core/error.h"

namespace acus::rf {
namespace {

/// Pixels from `peak` to where `value` falls to half, in steps of `step`.
double ToHalf(const std::function<float(int)>& value, int peak, int count, int step) {
  const float half = 0.5F * value(peak);
  for (int i = peak + step; i >= 0 && i < count; i += step) {
    const float here = value(i);
    if (here > half) continue;
    const float before = value(i - step);
    return std::abs(i - peak) - static_cast<double>((half - here) / (before - here));
  }
  throw NoAnswerError("the envelope does not fall to half of its maximum within the image");
}

double FullWidth(const std::function<float(int)>& value, int peak, int count) {
  return ToHalf(value, peak, count, -1) + ToHalf(value, peak, count, 1);
}

}  // namespace

PointWidths WidthsOfBrightest(const IqImage& image) {
  const std::vector<float> envelope = Envelope(image);
  const PixelGrid& grid = image.grid;
  const auto brightest = static_cast<int>(std::ranges::max_element(envelope) - envelope.begin());
  const int column = brightest % grid.columns;
  const int row = brightest / grid.columns;
  const auto at = [&](int c, int r) {
    return envelope[static_cast<std::size_t>(r) * grid.columns + c];
  };
  PointWidths out;
  out.peak_mm = grid.At(column, row);
  out.lateral_mm =
      grid.step_mm.x() * FullWidth([&](int c) { return at(c, row); }, column, grid.columns);
  out.axial_mm = grid.step_mm.y() * FullWidth([&](int r) { return at(column, r); }, row, grid.rows);
  return out;
}

double SpeckleSnr(std::span<const float> envelope) {
  ACUS_REQUIRE(envelope.size() >= 2, "speckle: ", envelope.size(),
               " values; at least 2 are needed");
  double mean = 0.0;
  for (const float value : envelope) mean += value;
  mean /= static_cast<double>(envelope.size());
  double square = 0.0;
  for (const float value : envelope) square += (value - mean) * (value - mean);
  ACUS_REQUIRE(square > 0.0, "speckle: all values are ", mean, "; they must differ");
  return mean / std::sqrt(square / static_cast<double>(envelope.size() - 1));
}

}  // namespace acus::rf
