#include "acus/base/report/svg_plot.h"

#include <algorithm>
#include <cmath>

#include "acus/base/core/atomic_file.h"
#include "acus/base/core/error.h"
#include "acus/base/report/axis.h"
#include "acus/base/report/markup.h"
#include "acus/base/report/plot_drawing.h"

namespace acus::report {
namespace {

void CheckColumn(const Plot& plot, const Series& series, const std::vector<double>& column,
                 const char* name, bool is_log) {
  ACUS_REQUIRE(column.size() == series.x.size(), "plot '", plot.title, "', series '", series.name,
               "': ", name, " has ", column.size(), " values, x has ", series.x.size());
  for (std::size_t i = 0; i < column.size(); ++i) {
    ACUS_REQUIRE(std::isfinite(column[i]), "plot '", plot.title, "', series '", series.name,
                 "', row ", i, ": ", name, " is not finite");
    ACUS_REQUIRE(!is_log || column[i] > 0.0, "plot '", plot.title, "', series '", series.name,
                 "', row ", i, ": ", name, " is ", column[i],
                 "; a logarithmic axis needs positive values");
  }
}

void Check(const Plot& plot) {
  for (const Series& series : plot.series) {
    CheckColumn(plot, series, series.x, "x", plot.log_x);
    const bool band = series.style == Style::kBand;
    if (!band) CheckColumn(plot, series, series.y, "y", plot.log_y);
    if (band || !series.low.empty() || !series.high.empty()) {
      CheckColumn(plot, series, series.low, "low", plot.log_y);
      CheckColumn(plot, series, series.high, "high", plot.log_y);
    }
    if (!series.x_low.empty() || !series.x_high.empty()) {
      CheckColumn(plot, series, series.x_low, "x_low", plot.log_x);
      CheckColumn(plot, series, series.x_high, "x_high", plot.log_x);
    }
    ACUS_REQUIRE(series.labels.empty() || series.labels.size() == series.x.size(), "plot '",
                 plot.title, "', series '", series.name, "': ", series.labels.size(),
                 " labels for ", series.x.size(), " points");
  }
  for (const Limit& limit : plot.limits) {
    ACUS_REQUIRE(std::isfinite(limit.y) && (!plot.log_y || limit.y > 0.0), "plot '", plot.title,
                 "', limit '", limit.text, "': y is ", limit.y,
                 "; it must be finite, and positive on a logarithmic axis");
  }
  for (const Mark& mark : plot.marks) {
    ACUS_REQUIRE(std::isfinite(mark.x), "plot '", plot.title, "', mark '", mark.text,
                 "': x is not finite");
    ACUS_REQUIRE(!(mark.widens && plot.log_x && mark.x <= 0.0), "plot '", plot.title, "', mark '",
                 mark.text, "': x is ", mark.x, "; a logarithmic axis needs positive values");
  }
  for (const Span& span : plot.spans) {
    ACUS_REQUIRE(std::isfinite(span.from_x) && std::isfinite(span.to_x), "plot '", plot.title,
                 "', span '", span.text, "': an end is not finite");
  }
}

Extent ExtentX(std::span<const Plot> plots) {
  Extent extent;
  for (const Plot& plot : plots) {
    for (const Series& series : plot.series) {
      extent.Add(series.x);
      extent.Add(series.x_low);
      extent.Add(series.x_high);
      if (series.style != Style::kBars || series.x.empty() || plot.log_x) continue;
      extent.Add(extent.low - HalfBar(series));
      extent.Add(extent.high + HalfBar(series));
    }
  }
  for (const Plot& plot : plots) {
    for (const Mark& mark : plot.marks) {
      if (mark.widens) extent.Add(mark.x);
    }
  }
  if (!extent.empty) return extent;
  for (const Plot& plot : plots) {  // No data: show at least where the events were.
    for (const Mark& mark : plot.marks) {
      if (!plot.log_x || mark.x > 0.0) extent.Add(mark.x);
    }
    for (const Span& span : plot.spans) {
      if (plot.log_x && (span.from_x <= 0.0 || span.to_x <= 0.0)) continue;
      extent.Add(span.from_x);
      extent.Add(span.to_x);
    }
  }
  return extent;
}

bool StartsAtZero(const Plot& plot) {
  const auto is_bars = [](const Series& series) { return series.style == Style::kBars; };
  return plot.y_from_zero || std::ranges::any_of(plot.series, is_bars);
}

Extent ExtentY(const Plot& plot) {
  Extent extent;
  for (const Series& series : plot.series) {
    if (series.style != Style::kBand) extent.Add(series.y);
    extent.Add(series.low);
    extent.Add(series.high);
  }
  for (const Limit& limit : plot.limits) extent.Add(limit.y);
  if (StartsAtZero(plot) && !plot.log_y) extent.Add(0.0);
  return extent;
}

bool HasPoints(const Plot& plot) {
  return std::ranges::any_of(plot.series,
                             [](const Series& series) { return series.style == Style::kPoints; });
}

std::string WithExponent(const std::string& label, int exponent) {
  if (exponent == 0) return label;
  const std::string factor = "\u00D7" + PowerOfTenText(exponent);
  return label.empty() ? factor : label + "  " + factor;
}

double WidestLabel(const Axis& axis) {
  double width = 0.0;
  for (const Tick& tick : axis.ticks()) width = std::max(width, TextWidth(tick.label));
  return width;
}

}  // namespace

std::string StackedSvgText(std::span<const Plot> plots) {
  ACUS_ASSERT(!plots.empty());
  bool points = false;
  for (const Plot& plot : plots) {
    Check(plot);
    ACUS_ASSERT(plot.log_x == plots.front().log_x);
    points = points || HasPoints(plot);
  }
  const double width = std::max(plots.front().width_px, 200);
  const Axis x_axis(ExtentX(plots), plots.front().log_x, points ? 0.02 : 0.0,
                    static_cast<int>(width / 75.0));
  std::vector<Axis> y_axes;
  double left = 0.0;
  for (const Plot& plot : plots) {
    y_axes.emplace_back(ExtentY(plot), plot.log_y, 0.05, std::max(plot.height_px, 80) / 34,
                        StartsAtZero(plot));
    left = std::max(left, 34.0 + WidestLabel(y_axes.back()));
  }
  const double right = width - 16.0;
  std::string body;
  double top = 6.0;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    const Plot& plot = plots[i];
    const bool last = i + 1 == plots.size();
    if (!plot.title.empty()) {
      body += TextAt(left, top + 13.0, plot.title, "font-size=\"14\" font-weight=\"bold\"");
      top += 20.0;
    }
    const auto legend = LegendOf(plot, left, right);
    body += LegendText(plot, legend, top);
    if (!legend.empty()) top += 17.0 * (legend.back().row + 1) + 5.0;
    const Frame frame{left, top + 4.0, right - left,
                      static_cast<double>(std::max(plot.height_px, 80))};
    body += PlotText(plot, x_axis, y_axes[i], frame, last);
    const double middle = frame.top + 0.5 * frame.height;
    body += TextAt(14.0, middle, WithExponent(plot.y_label, y_axes[i].exponent()),
                   Message("text-anchor=\"middle\" transform=\"rotate(-90 14 ", Px(middle), ")\""));
    top = frame.bottom() + 14.0;
    if (!last) continue;
    const double depth = LabelDepth(plot, x_axis, frame.width);
    body += TextAt(0.5 * (left + right), frame.bottom() + depth + 18.0,
                   WithExponent(plot.x_label, x_axis.exponent()), "text-anchor=\"middle\"");
    top = frame.bottom() + depth + (plot.x_label.empty() ? 10.0 : 28.0);
  }
  const std::string title = Escaped(plots.front().title);
  return Message("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"", Px(width), "\" height=\"",
                 Px(top), "\" viewBox=\"0 0 ", Px(width), " ", Px(top),
                 "\" role=\"img\" aria-label=\"", title,
                 "\" font-family=\"DejaVu Sans, Helvetica, Arial, sans-serif\" font-size=\"12\" "
                 "fill=\"#222222\">\n<title>",
                 title, "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n", body,
                 "</svg>\n");
}

std::string SvgText(const Plot& plot) {
  return StackedSvgText(std::span(&plot, 1));
}

void WriteSvg(const std::filesystem::path& path, std::span<const Plot> plots) {
  WriteTextFile(path, StackedSvgText(plots));
}

void WriteSvg(const std::filesystem::path& path, const Plot& plot) {
  WriteSvg(path, std::span(&plot, 1));
}

}  // namespace acus::report
