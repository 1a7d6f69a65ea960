// Sheets to print at true scale: calibration boards and facets.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "acus/rig/camera/board.h"
#include "acus/rig/camera/facets.h"

namespace acus::camera {

/// Millimetres from the top left of the paper, y downwards.
struct Rectangle {
  Eigen::Vector2d corner_mm;  ///< Top left.
  Eigen::Vector2d size_mm;
};
struct Words {
  Eigen::Vector2d at_mm;  ///< Left end of the base line.
  double height_mm = 3.0;
  std::string text;  ///< ASCII.
};
struct Sheet {
  std::string name;  ///< For a file name: letters, digits, '_' and '-'.
  Eigen::Vector2d paper_mm = {210.0, 297.0};
  std::vector<Rectangle> black;
  std::vector<Words> words;
};

/// The board, with a ruler of 100 mm (less on small paper) to check the scale of the print.
Sheet BoardSheet(const CalibrationBoard& board);
/// One sheet of A4 for each facet, with lines to cut along and its frame's axes; larger paper where
/// the facet does not fit.
std::vector<Sheet> FacetSheets(const FacetSet& facets);

/// Writes <name>.svg and <name>.png (300 pixels per inch, which the file says) for each sheet, and
/// all sheets as `all`.pdf, a page each, into an existing folder. The same sheets give the same
/// bytes. @throws InputError if a file cannot be written.
void WriteSheets(const std::filesystem::path& folder, const std::string& all,
                 const std::vector<Sheet>& sheets);

/// One page each, 72 points an inch, Helvetica.
std::string PdfText(const std::vector<Sheet>& sheets);
std::string SvgText(const Sheet& sheet);

}  // namespace acus::camera
