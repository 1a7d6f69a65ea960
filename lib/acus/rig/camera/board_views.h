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
  int misread = 0;       ///< Markers that lie elsewhere than on the board; not used.
  std::string rejected;  ///< Why the view is of no use; empty if it is.
};

struct BoardViews {
  int width_px = 0;  ///< Of the first image.
  int height_px = 0;
  std::vector<BoardView> views;  ///< In the order of the files.
};

/// Finds the board's corners in each image. Markers that do not lie as on the board, by a
/// homography that most of them agree on, are misread and omitted. Views with fewer than
/// `least_corners` corners, with all of them in one row or column, or of another size than the
/// first are rejected.
/// @throws InputError if a file cannot be read.
/// @throws NoAnswerError if the markers do not lie as on this board, but as on one with rows and
///     columns swapped or another first square: see ExplainLayout.
BoardViews FindBoardViews(const std::vector<std::filesystem::path>& files,
                          const CalibrationBoard& board, int least_corners,
                          const RunContext& context);

/// The markers of an image that lie as on the board, by a homography that most of them agree on;
/// all, where fewer than four are on the board.
std::vector<DetectedMarker> WithoutMisread(const std::vector<DetectedMarker>& seen,
                                           const CalibrationBoard& board);

/// Which other board the markers of all images fit far better than this one, as text for a message;
/// empty if there is none. A board fits if one homography maps three quarters of its markers to
/// those of an image, each to within 0.6 of its side, so that the distortion of a lens does not
/// count.
std::string ExplainLayout(const std::vector<std::vector<DetectedMarker>>& images,
                          const CalibrationBoard& board);

}  // namespace acus::camera
