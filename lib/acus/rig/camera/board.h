// The board that cameras are calibrated with: a chessboard with markers in its white squares
// (ChArUco), so that each of its corners is known even if only a part of the board is seen.
#pragma once

#include <Eigen/Dense>
#include <filesystem>
#include <string>
#include <vector>

#include "acus/rig/camera/facets.h"
#include "acus/rig/camera/marker_detector.h"

namespace acus::camera {

/// Which squares hold the markers: programs that print such boards differ in this.
enum class FirstSquare {
  kBlack,        ///< The top left square is black: OpenCV from 4.6 on.
  kMarker,       ///< The top left square holds marker 0.
  kOpenCvLegacy  ///< OpenCV before 4.6: the bottom left square is black.
};

/// Its frame: origin in the middle, x to the right and y up as printed, z out of the paper. Markers
/// are numbered row by row from the top left.
struct CalibrationBoard {
  std::string name;
  std::string dictionary;
  int columns = 0;  ///< Squares.
  int rows = 0;
  double square_mm = 0.0;
  FirstSquare first_square = FirstSquare::kBlack;
  int quiet_modules = 1;
  double marker_mm = 0.0;  ///< Of a board printed by another program; 0: from quiet_modules.
  Eigen::Vector2d paper_mm = {210.0, 297.0};

  double ModuleMm() const;
  double MarkerMm() const;
  /// Whether a square is white and holds a marker. Counted from the top left.
  bool HoldsMarker(int column, int row) const;
  /// All squares of the print: bits[row][column], true is white. @pre marker_mm is 0.
  std::vector<std::vector<bool>> Modules() const;
  /// Markers in the board's frame.
  std::vector<Marker> Markers() const;
  /// Where four squares meet: (columns - 1) * (rows - 1), row by row from the top left.
  std::vector<Eigen::Vector3d> CornersMm() const;
};

/// A file of format acus-camera-board/1.
/// @throws InputError as ReadConfig does, if the dictionary has too few markers, or the paper is
///     too small.
CalibrationBoard ReadBoard(const std::filesystem::path& path);

/// A corner of the board in an image.
struct BoardCorner {
  std::size_t number;  ///< In CornersMm().
  Eigen::Vector2d pixel;
};

/// Corners beside which at least one marker was read, to a few hundredths of a pixel; by number.
/// Empty if fewer than two markers were read.
std::vector<BoardCorner> FindBoardCorners(const Image& image, const CalibrationBoard& board,
                                          MarkerDetector& detector);
/// The same with the markers that were detected in the image.
std::vector<BoardCorner> FindBoardCorners(const Image& image, const CalibrationBoard& board,
                                          const std::vector<DetectedMarker>& seen);

}  // namespace acus::camera
