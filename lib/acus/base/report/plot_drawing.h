// Drawing one plot into its frame: the parts that svg_plot puts together.
#pragma once

#include <string>
#include <vector>

#include "acus/base/report/axis.h"
#include "acus/base/report/svg_plot.h"

namespace acus::report {

/// The rectangle of the axes, pixels.
struct Frame {
  double left;
  double top;
  double width;
  double height;
  double bottom() const { return top + height; }
  double right() const { return left + width; }
};

/// An entry of the legend: which series, where, in which row.
struct LegendEntry {
  std::size_t series;
  double x;
  int row;
};

/// A coordinate with one digit after the point, as short as can be.
std::string Px(double value);

/// Estimated width of a text in the plot's font.
double TextWidth(const std::string& text, double font_px = 12.0);

/// A <text> element; `extra` are further attributes.
std::string TextAt(double x, double y, const std::string& text, const std::string& extra);

/// Half the width of a histogram bar, in units of x.
double HalfBar(const Series& series);

/// The named series from left to right, in as many rows as they need.
std::vector<LegendEntry> LegendOf(const Plot& plot, double left, double right);
std::string LegendText(const Plot& plot, const std::vector<LegendEntry>& entries, double top);

/// Height of the labels under an axis of `width` pixels: more where names have to be slanted.
double LabelDepth(const Plot& plot, const Axis& x_axis, double width);

/// Ground, grid, tick labels (those of x only if `labels_x`), marks and series of one plot.
std::string PlotText(const Plot& plot, const Axis& x_axis, const Axis& y_axis, const Frame& frame,
                     bool labels_x);

}  // namespace acus::report
