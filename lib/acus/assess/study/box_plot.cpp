#include "acus/assess/study/box_plot.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/error.h"
#include "acus/base/core/text_table.h"
#include "acus/base/math/statistics.h"
#include "acus/base/report/markup.h"

namespace acus::study {
namespace {

constexpr double kWidthPx = 300.0;
constexpr double kHeightPx = 240.0;
constexpr double kTopPx = 34.0;
constexpr double kBottomPx = 206.0;
constexpr double kLeftPx = 58.0;

std::string Px(double value) {
  return FixedText(value, 1);
}

std::string Words(double x, double y, const std::string& text, const char* anchor) {
  return Message("<text x=\"", Px(x), "\" y=\"", Px(y), "\" text-anchor=\"", anchor,
                 "\" font-size=\"12\" fill=\"#333\">", report::Escaped(text), "</text>\n");
}

std::string Line(double x1, double y1, double x2, double y2, const char* style) {
  return Message("<line x1=\"", Px(x1), "\" y1=\"", Px(y1), "\" x2=\"", Px(x2), "\" y2=\"", Px(y2),
                 "\" ", style, "/>\n");
}

/// Maps values to pixels.
struct Axis {
  double least = 0.0;
  double greatest = 1.0;
  double Y(double value) const {
    return kBottomPx - (value - least) / (greatest - least) * (kBottomPx - kTopPx);
  }
};

Axis AxisOf(std::span<const Box> boxes) {
  Axis axis{boxes.front().values.front(), boxes.front().values.front()};
  for (const Box& box : boxes) {
    const auto [least, greatest] = std::ranges::minmax(box.values);
    axis.least = std::min(axis.least, least);
    axis.greatest = std::max(axis.greatest, greatest);
  }
  const double span = axis.greatest - axis.least;
  const double margin = span > 0.0 ? 0.05 * span : std::max(1.0, std::abs(axis.least));
  axis.least -= margin;
  axis.greatest += margin;
  return axis;
}

std::string BoxSvg(const Box& box, const Axis& axis, double x, double half_px, const char* fill) {
  const double q1 = math::Quantile(box.values, 0.25);
  const double q3 = math::Quantile(box.values, 0.75);
  const double reach = 1.5 * (q3 - q1);
  double low = q1, high = q3;
  for (const double value : box.values) {
    if (value >= q1 - reach) low = std::min(low, value);
    if (value <= q3 + reach) high = std::max(high, value);
  }
  constexpr const char* kThin = "stroke=\"#333\"";
  std::string svg = Line(x, axis.Y(low), x, axis.Y(q1), kThin) +
                    Line(x, axis.Y(q3), x, axis.Y(high), kThin) +
                    Line(x - 0.4 * half_px, axis.Y(low), x + 0.4 * half_px, axis.Y(low), kThin) +
                    Line(x - 0.4 * half_px, axis.Y(high), x + 0.4 * half_px, axis.Y(high), kThin);
  svg += Message("<rect x=\"", Px(x - half_px), "\" y=\"", Px(axis.Y(q3)), "\" width=\"",
                 Px(2.0 * half_px), "\" height=\"", Px(axis.Y(q1) - axis.Y(q3)), "\" fill=\"", fill,
                 "\" stroke=\"#333\"/>\n");
  const double median_y = axis.Y(math::Median(box.values));
  svg += Line(x - half_px, median_y, x + half_px, median_y, "stroke=\"#000\" stroke-width=\"2.5\"");
  for (std::size_t i = 0; i < box.values.size(); ++i) {
    // Side by side, so that equal values are visible.
    const double off = half_px * 0.7 * (static_cast<double>(i % 5) / 2.0 - 1.0);
    svg += Message("<circle cx=\"", Px(x + off), "\" cy=\"", Px(axis.Y(box.values[i])),
                   "\" r=\"2.5\" fill=\"#222\" fill-opacity=\"0.55\"/>\n");
  }
  return svg;
}

}  // namespace

std::string BoxPlotSvg(const std::string& title, const std::string& unit,
                       std::span<const Box> boxes) {
  std::string svg = Message("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"", kWidthPx,
                            "\" height=\"", kHeightPx, "\" viewBox=\"0 0 ", kWidthPx, " ",
                            kHeightPx, "\" font-family=\"sans-serif\">\n<rect width=\"", kWidthPx,
                            "\" height=\"", kHeightPx, "\" fill=\"#fff\"/>\n");
  svg += Words(0.5 * kWidthPx, 18.0, title + (unit.empty() ? "" : " [" + unit + "]"), "middle");
  if (boxes.empty()) {
    return svg + Words(0.5 * kWidthPx, 0.5 * kHeightPx, "no values", "middle") + "</svg>\n";
  }
  const Axis axis = AxisOf(boxes);
  constexpr int kTicks = 5;
  for (int tick = 0; tick < kTicks; ++tick) {
    const double value = axis.least + (axis.greatest - axis.least) * tick / (kTicks - 1.0);
    svg += Line(kLeftPx, axis.Y(value), kWidthPx - 8.0, axis.Y(value), "stroke=\"#ddd\"");
    svg += Words(kLeftPx - 6.0, axis.Y(value) + 4.0, RoundedText(value, 3), "end");
  }
  const double step = (kWidthPx - kLeftPx - 8.0) / static_cast<double>(boxes.size());
  constexpr const char* kFills[] = {"#9ecae1", "#fdae6b", "#a1d99b", "#bcbddc"};
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const double x = kLeftPx + step * (static_cast<double>(i) + 0.5);
    svg += BoxSvg(boxes[i], axis, x, std::min(30.0, 0.32 * step), kFills[i % 4]);
    svg += Words(x, kBottomPx + 18.0, Message(boxes[i].name, " (", boxes[i].values.size(), ")"),
                 "middle");
  }
  return svg + "</svg>\n";
}

}  // namespace acus::study
