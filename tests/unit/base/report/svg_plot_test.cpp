#include "acus/base/report/svg_plot.h"

#include <cmath>
#include <gmock/gmock.h>
#include <limits>
#include <numbers>
#include <regex>

#include "acus/base/core/error.h"
#include "acus/base/core/random.h"

namespace acus::report {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::ThrowsMessage;

Plot OneSeries(std::vector<double> x, std::vector<double> y, Style style = Style::kLine) {
  Plot plot{.title = "Force", .x_label = "depth [mm]", .y_label = "force [N]"};
  plot.series.push_back({.name = "axial", .x = std::move(x), .y = std::move(y), .style = style});
  return plot;
}

struct Point {
  double x;
  double y;
};

/// The points of the n-th series' path, in values: what a reader of the plot would read off.
std::vector<Point> ReadOff(const std::string& svg) {
  std::smatch m;
  static const std::regex frame(R"re(data-frame="(\S+) (\S+) (\S+) (\S+)" )re"
                                R"re(data-x="(\S+) (\S+) \w+" data-y="(\S+) (\S+) \w+")re");
  EXPECT_TRUE(std::regex_search(svg, m, frame));
  std::array<double, 8> f{};
  for (std::size_t i = 0; i < 8; ++i) f[i] = std::stod(m[static_cast<int>(i) + 1]);
  const std::size_t series = svg.find("class=\"series\"");
  const std::size_t begin = svg.find("<path d=\"M", series) + 10;
  std::string path = svg.substr(begin, svg.find('"', begin) - begin);
  for (char& c : path) c = c == ',' || c == 'M' || c == 'h' || c == 'z' ? ' ' : c;
  std::istringstream words(path);
  std::vector<Point> points;
  for (double x = 0, y = 0; words >> x >> y;) {
    points.push_back({f[4] + (x - f[0]) / f[2] * (f[5] - f[4]),
                      f[6] + (f[1] + f[3] - y) / f[3] * (f[7] - f[6])});
  }
  return points;
}

TEST(SvgText, ShowsEachValueWhereTheAxesSay) {
  const auto points = ReadOff(SvgText(OneSeries({0, 10, 40}, {0.5, -1.5, 2.0})));
  ASSERT_EQ(points.size(), 3U);
  EXPECT_NEAR(points[1].x, 10.0, 0.01);
  EXPECT_NEAR(points[1].y, -1.5, 0.002);
  EXPECT_NEAR(points[2].x, 40.0, 0.01);
  EXPECT_NEAR(points[2].y, 2.0, 0.002);
}

TEST(SvgText, KeepsTheExtremesOfALongSeriesAndStaysSmall) {
  Plot plot{.title = "Long"};
  RandomStream random(1, "plot");
  for (int s = 0; s < 4; ++s) {
    Series series{.name = "s"};
    for (int i = 0; i < 30000; ++i) {
      series.x.push_back(i * 1e-3);
      series.y.push_back(std::sin(i * 1e-3) + 0.1 * random.Normal());
    }
    plot.series.push_back(series);
  }
  plot.series[0].y[12345] = 9.0;   // One sample among 30000 must still be seen,
  plot.series[0].y[12346] = -7.0;  // and so must its neighbour.
  const std::string svg = SvgText(plot);
  EXPECT_LT(svg.size(), 200000U);
  double high = -100;
  double low = 100;
  for (const Point& point : ReadOff(svg)) {
    high = std::max(high, point.y);
    low = std::min(low, point.y);
  }
  EXPECT_NEAR(high, 9.0, 0.01);
  EXPECT_NEAR(low, -7.0, 0.01);
}

TEST(SvgText, StaysSmallWhenALineRunsToAndFro) {
  std::vector<double> x(50000);
  std::vector<double> y(50000);
  RandomStream random(2, "plot");
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = random.Uniform(0, 80);
    y[i] = random.Uniform(0, 3);
  }
  EXPECT_LT(SvgText(OneSeries(x, y)).size(), 200000U);
  EXPECT_LT(SvgText(OneSeries(x, y, Style::kPoints)).size(), 200000U);
  EXPECT_LT(SvgText(OneSeries(x, y, Style::kBars)).size(), 1000000U);
}

TEST(SvgText, HandlesEmptyConstantHugeAndSmall) {
  EXPECT_THAT(SvgText(Plot{.title = "Nothing"}), HasSubstr("no data"));
  EXPECT_THAT(SvgText(OneSeries({}, {})), HasSubstr("no data"));
  EXPECT_THAT(SvgText(OneSeries({1, 2}, {3, 3})), Not(HasSubstr("nan")));
  for (const double size : {1.79e308, 1e308, 1e-308, 1e300, 1e-15, 5e-324, 1e9}) {
    const std::string svg = SvgText(OneSeries({-size, size}, {size, -size}));
    EXPECT_THAT(svg, AllOf(Not(HasSubstr("nan")), Not(HasSubstr("inf")))) << size;
  }
  EXPECT_THAT(SvgText(OneSeries({0, 1}, {0, 2e-6})), HasSubstr("force [N]  \u00D710\u207B\u2076"));
}

TEST(SvgText, RefusesWhatCannotBeDrawnAndSaysWhere) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto draw = [](const Plot& plot) { return [plot] { return SvgText(plot); }; };
  EXPECT_THAT(draw(OneSeries({0, 1}, {0, nan})),
              ThrowsMessage<InputError>(AllOf(HasSubstr("'Force'"), HasSubstr("'axial'"),
                                              HasSubstr("row 1"), HasSubstr("not finite"))));
  EXPECT_THAT(draw(OneSeries({0, 1}, {0})),
              ThrowsMessage<InputError>(HasSubstr("1 values, x has 2")));
  Plot half = OneSeries({0, 1}, {0, 1});
  half.series.front().low = {0, 1};  // And no high.
  EXPECT_THAT(draw(half), ThrowsMessage<InputError>(HasSubstr("high")));
  half.series.front().low.clear();
  half.series.front().x_high = {0, 1};
  EXPECT_THAT(draw(half), ThrowsMessage<InputError>(HasSubstr("x_low")));
  Plot logarithmic = OneSeries({1, 2}, {1, 0});
  logarithmic.log_y = true;
  EXPECT_THAT(draw(logarithmic), ThrowsMessage<InputError>(HasSubstr("needs positive values")));
  Plot marked = OneSeries({1, 2}, {1, 0});
  marked.marks.push_back({nan, "puncture"});
  EXPECT_THAT(draw(marked), ThrowsMessage<InputError>(HasSubstr("mark 'puncture'")));
}

TEST(SvgText, EscapesTextsAndKeepsUnicode) {
  Plot plot = OneSeries({0, 1}, {0, 1});
  plot.title = "a<b & \"c\" \x01 \xFF µm";
  plot.marks.push_back({0.5, "<skin>"});
  const std::string svg = SvgText(plot);
  EXPECT_THAT(svg, HasSubstr("a&lt;b &amp; &quot;c&quot;   \uFFFD µm"));
  EXPECT_THAT(svg, HasSubstr("&lt;skin&gt;"));
}

TEST(StackedSvgText, SharesTheAxisOfX) {
  const std::vector<Plot> plots{OneSeries({0, 10}, {0, 1}), OneSeries({5, 30}, {2, 4})};
  const std::string svg = StackedSvgText(plots);
  const std::size_t first = svg.find("data-x=\"0 30 linear\"");
  EXPECT_NE(first, svg.npos);
  EXPECT_NE(svg.find("data-x=\"0 30 linear\"", first + 1), svg.npos);
  const std::size_t label = svg.find("depth [mm]");
  EXPECT_NE(label, svg.npos);
  EXPECT_EQ(svg.find("depth [mm]", label + 1), svg.npos) << "the label stands at the bottom only";
}

TEST(SvgText, PutsNamesUnderTheAxisAndSlantsThemWhereTheyAreLong) {
  Plot plot = OneSeries({0, 1, 2}, {4, 8, 2}, Style::kBars);
  plot.x_names = {"skin", "fat", "bone"};
  EXPECT_THAT(SvgText(plot), AllOf(HasSubstr(">fat</text>"), Not(HasSubstr("rotate(-35"))));
  plot.x_names = {std::string(60, 'a'), "<b>", "c"};
  plot.width_px = 300;
  const std::string svg = SvgText(plot);
  EXPECT_THAT(svg, AllOf(HasSubstr("rotate(-35"), HasSubstr("&lt;b&gt;")));
  EXPECT_THAT(svg, HasSubstr(std::string(28, 'a') + "\u2026"));
}

TEST(SvgText, DrawsBarsFromZero) {
  const std::string svg = SvgText(OneSeries({1, 2, 3}, {4, 8, 2}, Style::kBars));
  static const std::regex bar(
      R"re(<rect x="(\S+)" y="\S+" width="(\S+)" height="(\S+)" fill="#0072b2")re");
  std::vector<double> heights;
  for (std::sregex_iterator it(svg.begin(), svg.end(), bar), end; it != end; ++it) {
    heights.push_back(std::stod((*it)[3]));
  }
  heights.erase(heights.begin());  // The first is the legend's.
  ASSERT_EQ(heights.size(), 3U);
  EXPECT_NEAR(heights[1] / heights[0], 2.0, 0.01);
  EXPECT_NEAR(heights[2] / heights[0], 0.5, 0.01);
}

Plot Tradeoff() {
  Plot plot{.title = "Tradeoff", .log_x = true, .log_y = true};
  plot.series.push_back({.name = "needle_nodes",
                         .x = {10, 20, 40},
                         .y = {1, 0.5, 0.25},
                         .style = Style::kPoints,
                         .low = {0.9, 0.4, 0.2},
                         .high = {1.1, 0.6, 0.3},
                         .x_low = {9, 18, 36},
                         .x_high = {11, 22, 44},
                         .labels = {"8", "15", "25"}});
  plot.series.push_back({.name = "default",
                         .x = {20},
                         .y = {0.5},
                         .style = Style::kPoints,
                         .symbol = Symbol::kRing,
                         .colour = Colour::kInk});
  return plot;
}

TEST(SvgText, PointsHaveTheirBarsLabelsAndSymbols) {
  const std::string svg = SvgText(Tradeoff());
  for (const char* label : {">8</text>", ">15</text>", ">25</text>"}) {
    EXPECT_THAT(svg, HasSubstr(label));
  }
  // Six bars of three lines each: the bar and its caps.
  const std::size_t bars = svg.find("stroke-opacity=\"0.8\"/>");
  const std::size_t begin = svg.rfind("<path", bars);
  const std::string path = svg.substr(begin, bars - begin);
  EXPECT_EQ(std::ranges::count(path, 'M'), 18);
  // The ring: once in the legend, once around its point.
  const std::regex ring(R"re(<circle [^>]*fill="none" stroke="#222222")re");
  EXPECT_EQ(std::distance(std::sregex_iterator(svg.begin(), svg.end(), ring), {}), 2);
}

TEST(SvgText, LimitsAndWideningMarksAreWithinTheAxes) {
  Plot plot = Tradeoff();
  plot.limits.push_back({0.001, "accurate enough"});
  plot.marks.push_back({5000.0, "budget", true});
  plot.marks.push_back({1e9, "far away"});
  const std::string svg = SvgText(plot);
  EXPECT_THAT(svg,
              AllOf(HasSubstr("accurate enough"), HasSubstr("budget"), Not(HasSubstr("far away"))));
  std::smatch m;
  ASSERT_TRUE(std::regex_search(
      svg, m, std::regex(R"re(data-x="(\S+) (\S+) log" data-y="(\S+) (\S+) log")re")));
  EXPECT_GE(std::stod(m[2]), 5000.0);
  EXPECT_LT(std::stod(m[2]), 1e5);
  EXPECT_LE(std::stod(m[3]), 0.001);
}

TEST(SvgText, WhatIsWrongWithPointsIsSaid) {
  Plot plot = Tradeoff();
  plot.series[0].labels.pop_back();
  EXPECT_THAT([&] { SvgText(plot); }, ThrowsMessage<InputError>(HasSubstr("2 labels for 3")));
  plot = Tradeoff();
  plot.series[0].low[1] = 0.0;
  EXPECT_THAT([&] { SvgText(plot); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("row 1"), HasSubstr("low is 0"))));
  plot = Tradeoff();
  plot.series[0].x_high.pop_back();
  EXPECT_THAT([&] { SvgText(plot); }, ThrowsMessage<InputError>(HasSubstr("x_high has 2 values")));
  plot = Tradeoff();
  plot.limits.push_back({0.0, "none"});
  EXPECT_THAT([&] { SvgText(plot); }, ThrowsMessage<InputError>(HasSubstr("limit 'none'")));
  plot = Tradeoff();
  plot.marks.push_back({-1.0, "gone", true});
  EXPECT_THAT([&] { SvgText(plot); }, ThrowsMessage<InputError>(HasSubstr("mark 'gone'")));
}

TEST(SvgText, LabelsDoNotLieOnOneAnother) {
  Plot plot{.title = "Crowd"};
  Series crowd{.name = "crowd", .style = Style::kPoints};
  for (int i = 0; i < 40; ++i) {
    crowd.x.push_back(i % 2);
    crowd.y.push_back(1.0);
    crowd.labels.push_back("label " + std::to_string(i));
  }
  plot.series.push_back(crowd);
  const std::string svg = SvgText(plot);
  int count = 0;
  for (std::size_t at = svg.find(">label "); at != svg.npos; at = svg.find(">label ", at + 1))
    ++count;
  EXPECT_GE(count, 4);
  EXPECT_LE(count, 12);  // Two places with room for six each.
}

}  // namespace
}  // namespace acus::report
