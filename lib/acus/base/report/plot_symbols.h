// What stands at single points of a plot: symbols, bars of uncertainty, labels.
#pragma once

#include <string>
#include <vector>

#include "acus/base/report/plot_drawing.h"
#include "acus/base/report/svg_plot.h"
#include "acus/base/report/thinning.h"

namespace acus::report {

/// A symbol with its middle at a pixel. @param colour  "#rrggbb".
std::string SymbolText(Symbol symbol, const PixelPoint& at, const std::string& colour);

/// A path of bars from each `from` to its `to`, which differ in x or in y, with caps at both ends.
/// @pre both are as long.
std::string BarsPath(const std::vector<PixelPoint>& from, const std::vector<PixelPoint>& to);

/// Finds room for texts beside points: the first place of a few that lies in the frame and on no
/// other text.
class LabelPlacer {
 public:
  explicit LabelPlacer(const Frame& frame) : frame_(frame) {}

  /// Keeps texts off a point.
  void Avoid(const PixelPoint& point);

  /// The text's element, or nothing if there is no room.
  std::string Place(const PixelPoint& point, const std::string& text, const std::string& colour);

 private:
  struct Box {
    double left;
    double top;
    double right;
    double bottom;
  };
  bool IsFree(const Box& box) const;

  Frame frame_;
  std::vector<Box> taken_;
};

}  // namespace acus::report
