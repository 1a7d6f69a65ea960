// The calibration board in a set of images.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/rig/camera/board.h"

namespace acus::camera {

struct BoardView {
  std::string file;
  std::vector<BoardCorner> corners;
  std::string rejected;  ///< Why the view is of no use; empty if it is.
};

struct BoardViews {
  int width_px = 0;  ///< Of the first image.
  int height_px = 0;
  std::vector<BoardView> views;  ///< In the order of the files.
};

/// Finds the board's corners in each image. Views with fewer than `least_corners` corners, with all
/// of them in one row or column, or of another size than the first are rejected.
/// @throws InputError if a file cannot be read.
/// @throws NoAnswerError if the markers do not lie as on this board, but as on one with rows and
///     columns swapped or another first square: see ExplainLayout.
BoardViews FindBoardViews(const std::vector<std::filesystem::path>& files,
                          const CalibrationBoard& board, int least_corners,
                          const RunContext& context);

/// Which other board the markers of all images fit far better than this one, as text for a message;
/// empty if there is none. A board fits if a homography maps its markers to those of an image.
std::string ExplainLayout(const std::vector<std::vector<DetectedMarker>>& images,
                          const CalibrationBoard& board);

}  // namespace acus::camera
