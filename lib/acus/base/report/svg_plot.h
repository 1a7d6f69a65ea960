// Scientific plots as SVG text: readable in a report, on paper and in a browser, small on disk.
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace acus::report {

enum class Style {
  kLine,    ///< x, y joined in the order given; x may go back (force over depth).
  kPoints,  ///< A dot at each x, y.
  kBand,    ///< Filled between low and high over x; y is not used.
  kBars,    ///< Histogram: a bar from 0 to y around each x, as wide as the smallest gap.
};

/// The shape of the points of a series.
enum class Symbol {
  kDot,
  kRing,     ///< Around a dot of another series: "this one".
  kDiamond,  ///< As large as the ring, of lines as well.
  kStar,     ///< Filled, larger than a dot: what the plot is about.
};

/// The colour of a series: that of its place in the plot, or that of texts, which stands for
/// remarks on others.
enum class Colour { kOwn, kInk };

struct Series {
  std::string name = {};  ///< In the legend; empty keeps it out.
  std::vector<double> x = {};
  std::vector<double> y = {};
  Style style = Style::kLine;
  /// Lower edge of a band, as long as x. For points: the ends of a bar through each, or empty.
  std::vector<double> low = {};
  std::vector<double> high = {};
  // For points only, each as long as x, or empty.
  std::vector<double> x_low = {};  ///< Ends of a level bar through each.
  std::vector<double> x_high = {};
  std::vector<std::string> labels =
      {};  ///< Beside the points; those that find no room are omitted.
  Symbol symbol = Symbol::kDot;
  Colour colour = Colour::kOwn;
  std::optional<std::size_t> colour_of = std::nullopt;  ///< That of the series at this place.
  bool dashed = false;                                  ///< Of a line.
};

/// A vertical line with a text: an event.
struct Mark {
  double x = 0.0;
  std::string text = {};
  bool widens = false;  ///< The x axis reaches it, instead of leaving it out.
};

/// A dashed level line with a text: a limit. The y axis reaches it.
struct Limit {
  double y = 0.0;
  std::string text = {};
};

/// A stretch of the x axis with a light ground: a phase.
struct Span {
  double from_x = 0.0;
  double to_x = 0.0;
  std::string text = {};
};

struct Plot {
  std::string title = {};
  std::string x_label = {};  ///< With the unit: "depth [mm]".
  std::string y_label = {};
  bool log_x = false;
  bool log_y = false;
  bool y_from_zero = false;               ///< The y axis reaches down (or up) to 0.
  std::vector<std::string> x_names = {};  ///< Stand at x = 0, 1, 2, ... instead of numbers.
  std::vector<Series> series = {};
  std::vector<Mark> marks = {};  ///< Those outside the x range are omitted, unless they widen it.
  std::vector<Span> spans = {};
  std::vector<Limit> limits = {};
  int width_px = 860;
  int height_px = 300;
};

/// One image of one plot. A plot without data says so inside its frame. UTF-8 texts are escaped.
///
/// Long series are thinned to what the pixels can show (per pixel column the first, smallest,
/// largest and last value stay), so that a plot stays below 200 kB.
/// @throws InputError naming plot, series and row if a value is not finite, is not positive on a
///     logarithmic axis, or the columns of a series have different lengths.
std::string SvgText(const Plot& plot);

/// Plots above each other with one x axis, labelled at the bottom; marks and spans of each stay
/// its own. The width is the first plot's. @pre not empty, all with the same log_x.
std::string StackedSvgText(std::span<const Plot> plots);

/// Writes StackedSvgText to a file, whole or not at all.
void WriteSvg(const std::filesystem::path& path, std::span<const Plot> plots);
void WriteSvg(const std::filesystem::path& path, const Plot& plot);

}  // namespace acus::report
