#include "acus/base/report/plot_drawing.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include "acus/base/core/csv.h"
#include "acus/base/core/error.h"
#include "acus/base/report/markup.h"
#include "acus/base/report/plot_symbols.h"
#include "acus/base/report/thinning.h"

namespace acus::report {
namespace {

// Okabe & Ito's palette without its yellow: distinguished with any colour vision, dark enough on
// white.
constexpr std::array<const char*, 7> kColours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                 "#e69f00", "#56b4e9", "#444444"};
constexpr const char* kInk = "#222222";
constexpr const char* kGrid = "#dedede";
constexpr const char* kMinorGrid = "#f1f1f1";
constexpr double kFontPx = 12.0;
constexpr double kCharacterPx = 7.0;  ///< Mean width of a character at kFontPx.
constexpr double kSlantDeg = 35.0;
constexpr int kLongestName = 28;       ///< Characters of a name under the axis.
constexpr int kMaxPathPoints = 11000;  ///< Of all series: about 150 kB of text.

std::string LineBetween(double x1, double y1, double x2, double y2, const std::string& extra) {
  return Message("<line x1=\"", Px(x1), "\" y1=\"", Px(y1), "\" x2=\"", Px(x2), "\" y2=\"", Px(y2),
                 "\" ", extra, "/>\n");
}

std::string Rectangle(double x1, double y1, double x2, double y2, const std::string& extra) {
  return Message("<rect x=\"", Px(std::min(x1, x2)), "\" y=\"", Px(std::min(y1, y2)), "\" width=\"",
                 Px(std::abs(x2 - x1)), "\" height=\"", Px(std::abs(y2 - y1)), "\" ", extra,
                 "/>\n");
}

const char* ColourOf(const Series& series, std::size_t index) {
  if (series.colour == Colour::kInk) return kInk;
  return kColours[series.colour_of.value_or(index) % kColours.size()];
}

/// Lines beyond the palette are distinguished by their dashes.
const char* DashesOf(const Series& series, std::size_t index) {
  if (series.dashed) return " stroke-dasharray=\"4 3\"";
  const bool again =
      series.colour == Colour::kOwn && series.colour_of.value_or(index) >= kColours.size();
  return again ? " stroke-dasharray=\"6 3\"" : "";
}

std::string PathOf(const std::vector<PixelPoint>& points) {
  std::string path;
  for (const PixelPoint& point : points) {
    path += (path.empty() ? "M" : " ") + Px(point.x) + "," + Px(point.y);
  }
  return path;
}

}  // namespace

std::string Px(double value) {
  std::array<char, 32> text{};
  const auto [end, error] =
      std::to_chars(text.data(), text.data() + text.size(), std::clamp(value, -1e6, 1e6),
                    std::chars_format::fixed, 1);
  std::string result(text.data(), end);
  if (result.ends_with(".0")) result.resize(result.size() - 2);
  return result == "-0" ? "0" : result;
}

namespace {

/// A name as it stands under the axis: the first characters of a long one.
std::string Shortened(const std::string& name) {
  std::string text;
  int count = 0;
  for (const char c : name) {
    count += (static_cast<unsigned char>(c) & 0xC0U) != 0x80;
    if (count > kLongestName) return text + "\u2026";
    text += c;
  }
  return text;
}

/// Pixels between the places of two names that stand side by side.
double NameSpacing(const Axis& x_axis, double width) {
  return width * (x_axis.Fraction(1.0) - x_axis.Fraction(0.0));
}

double WidestName(const Plot& plot) {
  double widest = 0.0;
  for (const auto& name : plot.x_names) widest = std::max(widest, TextWidth(Shortened(name)));
  return widest;
}

}  // namespace

double TextWidth(const std::string& text, double font_px) {
  return NumCharacters(text) * kCharacterPx * font_px / kFontPx;
}

std::string TextAt(double x, double y, const std::string& text, const std::string& extra) {
  return Message("<text x=\"", Px(x), "\" y=\"", Px(y), "\" ", extra, ">", Escaped(text),
                 "</text>\n");
}

double HalfBar(const Series& series) {
  std::vector<double> x = series.x;
  std::ranges::sort(x);
  double gap = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (x[i] > x[i - 1]) gap = std::min(gap, x[i] - x[i - 1]);
  }
  return std::isfinite(gap) ? 0.5 * gap : 0.5;
}

double LabelDepth(const Plot& plot, const Axis& x_axis, double width) {
  const double widest = WidestName(plot);
  if (widest + 6.0 <= NameSpacing(x_axis, width)) return 16.0;
  return 16.0 + widest * std::sin(kSlantDeg * std::numbers::pi / 180.0);
}

std::vector<LegendEntry> LegendOf(const Plot& plot, double left, double right) {
  std::vector<LegendEntry> entries;
  double x = left;
  int row = 0;
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    if (plot.series[i].name.empty()) continue;
    const double width = 28.0 + TextWidth(plot.series[i].name) + 14.0;
    if (x + width > right && x > left) {
      x = left;
      ++row;
    }
    entries.push_back({i, x, row});
    x += width;
  }
  return entries;
}

std::string LegendText(const Plot& plot, const std::vector<LegendEntry>& entries, double top) {
  std::string out;
  for (const LegendEntry& entry : entries) {
    const Series& series = plot.series[entry.series];
    const char* colour = ColourOf(series, entry.series);
    const double y = top + 10.0 + 17.0 * entry.row;
    if (series.style == Style::kLine) {
      out += LineBetween(
          entry.x, y, entry.x + 22.0, y,
          Message("stroke=\"", colour, "\" stroke-width=\"2.5\"", DashesOf(series, entry.series)));
    } else if (series.style == Style::kPoints) {
      out += SymbolText(series.symbol, {entry.x + 11.0, y}, colour) + "\n";
    } else {
      out += Rectangle(entry.x, y - 5.0, entry.x + 22.0, y + 5.0,
                       Message("fill=\"", colour, "\" fill-opacity=\"",
                               series.style == Style::kBand ? "0.3" : "0.8", "\""));
    }
    out += TextAt(entry.x + 28.0, y + 4.0, series.name, "");
  }
  return out;
}

namespace {

/// Draws one plot into its frame. All members refer to the caller's.
class PlotDrawing {
 public:
  PlotDrawing(const Plot& plot, const Axis& x_axis, const Axis& y_axis, const Frame& frame)
      : plot_(plot), x_axis_(x_axis), y_axis_(y_axis), frame_(frame) {}

  std::string Text(bool labels_x) {
    out_ =
        Message("<g class=\"plot\" data-frame=\"", Px(frame_.left), " ", Px(frame_.top), " ",
                Px(frame_.width), " ", Px(frame_.height), "\" data-x=\"", NumberText(x_axis_.low()),
                " ", NumberText(x_axis_.high()), " ", x_axis_.is_log() ? "log" : "linear",
                "\" data-y=\"", NumberText(y_axis_.low()), " ", NumberText(y_axis_.high()), " ",
                y_axis_.is_log() ? "log" : "linear", "\">\n");
    DrawSpans();
    DrawGrid(labels_x);
    DrawMarks();
    const bool empty =
        std::ranges::all_of(plot_.series, [](const Series& s) { return s.x.empty(); });
    if (empty) {
      out_ += TextAt(frame_.left + 0.5 * frame_.width, frame_.top + 0.5 * frame_.height, "no data",
                     "text-anchor=\"middle\" fill=\"#777777\"");
    }
    for (const bool bands : {true, false}) {  // Bands lie under the lines that run through them.
      for (std::size_t i = 0; i < plot_.series.size(); ++i) {
        if ((plot_.series[i].style == Style::kBand) == bands) DrawSeries(i);
      }
    }
    DrawMarkTexts();
    DrawLimits();
    DrawLabels();
    out_ += Rectangle(frame_.left, frame_.top, frame_.right(), frame_.bottom(),
                      "fill=\"none\" stroke=\"#888888\"");
    return std::move(out_) + "</g>\n";
  }

 private:
  double PixelX(double x) const { return frame_.left + x_axis_.Fraction(x) * frame_.width; }
  double PixelY(double y) const { return frame_.bottom() - y_axis_.Fraction(y) * frame_.height; }

  bool Shows(double x) const {
    if (x_axis_.is_log() && x <= 0.0) return false;
    const double fraction = x_axis_.Fraction(x);
    return fraction >= -1e-9 && fraction <= 1.0 + 1e-9;
  }

  void DrawSpans() {
    for (const Span& span : plot_.spans) {
      const double low = std::max(std::min(span.from_x, span.to_x), x_axis_.low());
      const double high = std::min(std::max(span.from_x, span.to_x), x_axis_.high());
      if (low > high) continue;
      const double from = PixelX(low);
      const double to = PixelX(high);
      out_ += Message(
          "<g><title>", Escaped(span.text), "</title>",
          Rectangle(from, frame_.top, to, frame_.bottom(), "fill=\"#f3ead2\" fill-opacity=\"0.7\""),
          "</g>");
      if (TextWidth(span.text, 10.0) > to - from - 4.0) continue;
      out_ += TextAt(0.5 * (from + to), frame_.bottom() - 5.0, span.text,
                     "text-anchor=\"middle\" font-size=\"10\" fill=\"#7a6520\"");
    }
  }

  void DrawGrid(bool labels_x) {
    const auto grid = [](const Tick& tick) {
      return Message("stroke=\"", tick.label.empty() ? kMinorGrid : kGrid, "\"");
    };
    if (labels_x && !plot_.x_names.empty()) DrawNames();
    for (const Tick& tick : x_axis_.ticks()) {
      if (!plot_.x_names.empty()) break;
      const double x = PixelX(tick.value);
      out_ += LineBetween(x, frame_.top, x, frame_.bottom(), grid(tick));
      if (labels_x && !tick.label.empty()) {
        out_ += TextAt(x, frame_.bottom() + 16.0, tick.label, "text-anchor=\"middle\"");
      }
    }
    for (const Tick& tick : y_axis_.ticks()) {
      const double y = PixelY(tick.value);
      out_ += LineBetween(frame_.left, y, frame_.right(), y, grid(tick));
      if (tick.label.empty()) continue;
      out_ += TextAt(frame_.left - 6.0, y + 4.0, tick.label, "text-anchor=\"end\"");
    }
    if (!y_axis_.is_log() && y_axis_.low() < 0.0 && y_axis_.high() > 0.0) {
      out_ +=
          LineBetween(frame_.left, PixelY(0.0), frame_.right(), PixelY(0.0), "stroke=\"#aaaaaa\"");
    }
  }

  void DrawNames() {
    const double spacing = NameSpacing(x_axis_, frame_.width);
    const bool slanted = WidestName(plot_) + 6.0 > spacing;
    const auto stride = static_cast<std::size_t>(std::ceil(kFontPx / std::max(spacing, 0.1)));
    for (std::size_t i = 0; i < plot_.x_names.size(); i += stride) {
      if (!Shows(static_cast<double>(i))) continue;
      const double x = PixelX(static_cast<double>(i));
      const double y = frame_.bottom() + (slanted ? 12.0 : 16.0);
      const std::string turn = Message("text-anchor=\"end\" transform=\"rotate(-", kSlantDeg, " ",
                                       Px(x), " ", Px(y), ")\"");
      out_ += TextAt(x, y, Shortened(plot_.x_names[i]), slanted ? turn : "text-anchor=\"middle\"");
    }
  }

  void DrawMarks() {
    for (const Mark& mark : plot_.marks) {
      if (!Shows(mark.x)) continue;
      const double x = PixelX(mark.x);
      out_ += Message("<g><title>", Escaped(mark.text), "</title>",
                      LineBetween(x, frame_.top, x, frame_.bottom(),
                                  "stroke=\"#777777\" stroke-dasharray=\"4 3\""),
                      "</g>\n");
    }
  }

  void DrawMarkTexts() {
    std::vector<Mark> marks = plot_.marks;
    std::ranges::stable_sort(marks, {}, &Mark::x);
    double labelled_to = -1e9;
    for (const Mark& mark : marks) {
      if (!Shows(mark.x)) continue;
      const double x = PixelX(mark.x);
      if (mark.text.empty() || x - labelled_to < 12.0) continue;  // The text would not be legible.
      labelled_to = x;
      // Right of the line: what led to the event stays in sight on its left.
      const double text_x = x + 11.0 < frame_.right() ? x + 11.0 : x - 3.0;
      const double text_y = frame_.top + 5.0;
      out_ += TextAt(text_x, text_y, mark.text,
                     Message("transform=\"rotate(-90 ", Px(text_x), " ", Px(text_y),
                             ")\" text-anchor=\"end\" font-size=\"10\" fill=\"#444444\" "
                             "paint-order=\"stroke\" stroke=\"#ffffff\" stroke-width=\"2\" "
                             "stroke-opacity=\"0.8\""));
    }
  }

  std::vector<PixelPoint> Pixels(const std::vector<double>& x, const std::vector<double>& y) const {
    std::vector<PixelPoint> pixels(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) pixels[i] = {PixelX(x[i]), PixelY(y[i])};
    return pixels;
  }

  void DrawSeries(std::size_t index) {
    const Series& series = plot_.series[index];
    if (series.x.empty()) return;
    const int budget = kMaxPathPoints / static_cast<int>(plot_.series.size());
    const char* colour = ColourOf(series, index);
    const std::string name =
        Message("<g class=\"series\" data-name=\"", Escaped(series.name), "\">");
    out_ += name;
    switch (series.style) {
      case Style::kLine:
        DrawLine(series, colour, budget, DashesOf(series, index));
        break;
      case Style::kPoints:
        DrawPoints(series, colour, budget);
        break;
      case Style::kBand:
        DrawBand(series, colour, budget);
        break;
      case Style::kBars:
        DrawBars(series, colour, budget);
        break;
    }
    out_ += "</g>\n";
  }

  void DrawLine(const Series& series, const char* colour, int budget, const char* dashes) {
    const auto points = ThinnedLine(Pixels(series.x, series.y), budget);
    if (points.size() == 1) return DrawPoints(series, colour, budget);
    out_ += Message("<path d=\"", PathOf(points), "\" fill=\"none\" stroke=\"", colour,
                    "\" stroke-width=\"1.5\" stroke-linejoin=\"round\"", dashes, "/>");
  }

  void DrawPoints(const Series& series, const char* colour, int budget) {
    // A line of no length with round ends is a dot, and the shortest way to write many of them.
    std::string path;
    for (const PixelPoint& point : ThinnedPoints(Pixels(series.x, series.y), 0.7, budget)) {
      path += "M" + Px(point.x) + "," + Px(point.y) + "h0";
    }
    const char* diameter = series.x.size() > 1000 ? "2.5" : "5";
    const bool dots = series.symbol == Symbol::kDot;
    out_ += Message("<path d=\"", path, "\" fill=\"none\" stroke=\"", dots ? colour : "none",
                    "\" stroke-width=\"", diameter, "\" stroke-linecap=\"round\"/>");
    DrawBarsThroughPoints(series, colour);
    for (std::size_t i = 0; !dots && i < series.x.size(); ++i) {
      out_ += SymbolText(series.symbol, {PixelX(series.x[i]), PixelY(series.y[i])}, colour);
    }
  }

  void DrawBarsThroughPoints(const Series& series, const char* colour) {
    std::string path;
    if (!series.low.empty()) {
      path += BarsPath(Pixels(series.x, series.low), Pixels(series.x, series.high));
    }
    if (!series.x_low.empty()) {
      path += BarsPath(Pixels(series.x_low, series.y), Pixels(series.x_high, series.y));
    }
    if (path.empty()) return;
    out_ += Message("<path d=\"", path, "\" fill=\"none\" stroke=\"", colour,
                    "\" stroke-width=\"1\" stroke-opacity=\"0.8\"/>");
  }

  void DrawLimits() {
    for (const Limit& limit : plot_.limits) {
      const double y = PixelY(limit.y);
      out_ += LineBetween(frame_.left, y, frame_.right(), y,
                          "stroke=\"#777777\" stroke-dasharray=\"4 3\"");
      out_ += TextAt(frame_.left + 5.0, y - 4.0, limit.text,
                     "font-size=\"10\" fill=\"#444444\" paint-order=\"stroke\" "
                     "stroke=\"#ffffff\" stroke-width=\"2\" stroke-opacity=\"0.8\"");
    }
  }

  void DrawLabels() {
    LabelPlacer placer(frame_);
    for (const Series& series : plot_.series) {
      for (std::size_t i = 0; i < series.labels.size(); ++i) {
        placer.Avoid({PixelX(series.x[i]), PixelY(series.y[i])});
      }
    }
    for (std::size_t n = 0; n < plot_.series.size(); ++n) {
      const Series& series = plot_.series[n];
      for (std::size_t i = 0; i < series.labels.size(); ++i) {
        out_ += placer.Place({PixelX(series.x[i]), PixelY(series.y[i])}, series.labels[i],
                             ColourOf(series, n));
      }
    }
  }

  void DrawBand(const Series& series, const char* colour, int budget) {
    auto outline = ThinnedLine(Pixels(series.x, series.high), budget / 2);
    const auto lower = ThinnedLine(Pixels(series.x, series.low), budget / 2);
    outline.insert(outline.end(), lower.rbegin(), lower.rend());
    out_ += Message("<path d=\"", PathOf(outline), "z\" fill=\"", colour,
                    "\" fill-opacity=\"0.22\" stroke=\"none\"/>");
  }

  void DrawBars(const Series& series, const char* colour, int budget) {
    // Bars of names stand apart, those of a histogram touch.
    const double half = HalfBar(series) * (plot_.x_names.empty() ? 1.0 : 0.6);
    const double base = y_axis_.is_log() ? frame_.bottom() : PixelY(0.0);
    const std::size_t stride = 1 + series.x.size() / static_cast<std::size_t>(budget / 2);
    for (std::size_t i = 0; i < series.x.size(); i += stride) {
      const double low = x_axis_.is_log() ? PixelX(series.x[i]) - 2.0 : PixelX(series.x[i] - half);
      const double high = x_axis_.is_log() ? PixelX(series.x[i]) + 2.0 : PixelX(series.x[i] + half);
      const double gap = high - low > 4.0 ? 0.5 : 0.0;
      out_ += Rectangle(low + gap, base, high - gap, PixelY(series.y[i]),
                        Message("fill=\"", colour, "\" fill-opacity=\"0.8\""));
    }
  }

  const Plot& plot_;
  const Axis& x_axis_;
  const Axis& y_axis_;
  Frame frame_;
  std::string out_;
};

}  // namespace

std::string PlotText(const Plot& plot, const Axis& x_axis, const Axis& y_axis, const Frame& frame,
                     bool labels_x) {
  return PlotDrawing(plot, x_axis, y_axis, frame).Text(labels_x);
}

}  // namespace acus::report
