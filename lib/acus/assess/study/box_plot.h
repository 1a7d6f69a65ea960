// Box plots as SVG.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace acus::study {

struct Box {
  std::string name;
  std::vector<double> values;  ///< Not empty, finite.
};

/// Boxes side by side: median, quartiles (type 7), whiskers to the farthest values within 1.5 times
/// the interquartile range (Tukey), and every value as a dot. Without boxes, the image states that.
std::string BoxPlotSvg(const std::string& title, const std::string& unit,
                       std::span<const Box> boxes);

}  // namespace acus::study
