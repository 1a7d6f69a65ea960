#include "acus/rig/camera/board_views.h"

#include <array>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <set>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::camera {
namespace {

/// A lens bends the board by a few per cent of a marker's side; a wrong layout moves whole squares.
constexpr double kWrongLayoutSides = 0.3;
/// The right layout fits better than a wrong one by this.
constexpr double kBetterBy = 4.0;
constexpr std::size_t kLeastMarkers = 4;

/// On fewer than two rows or columns a view says next to nothing, and the solver may fail.
bool IsSpread(const std::vector<BoardCorner>& corners, int columns) {
  std::set<std::size_t> rows, columns_seen;
  const auto across = static_cast<std::size_t>(columns - 1);
  for (const BoardCorner& corner : corners) {
    rows.insert(corner.number / across);
    columns_seen.insert(corner.number % across);
  }
  return rows.size() >= 2 && columns_seen.size() >= 2;
}

/// RMS distance of the markers' corners from their places by the best homography, in sides of the
/// markers. Nothing if fewer than four markers of the board were seen.
std::optional<double> LayoutError(const std::vector<DetectedMarker>& seen,
                                  const std::vector<Marker>& markers) {
  std::vector<cv::Point2f> from, to;
  double side_px = 0.0;
  for (const DetectedMarker& detected : seen) {
    if (detected.id < 0 || detected.id >= static_cast<int>(markers.size())) continue;
    const auto corners = markers[static_cast<std::size_t>(detected.id)].CornersInObjectMm();
    for (std::size_t k = 0; k < 4; ++k) {
      from.emplace_back(static_cast<float>(corners[k][0]), static_cast<float>(corners[k][1]));
      to.emplace_back(static_cast<float>(detected.corners_px[k][0]),
                      static_cast<float>(detected.corners_px[k][1]));
      side_px += (detected.corners_px[(k + 1) % 4] - detected.corners_px[k]).norm();
    }
  }
  if (from.size() < 4 * kLeastMarkers) return std::nullopt;
  side_px /= static_cast<double>(from.size());
  const cv::Mat map = cv::findHomography(from, to);
  if (map.empty()) return std::nullopt;
  std::vector<cv::Point2f> mapped;
  cv::perspectiveTransform(from, mapped, map);
  return cv::norm(mapped, to) / std::sqrt(static_cast<double>(from.size())) / side_px;
}

double MedianLayoutError(const std::vector<std::vector<DetectedMarker>>& images,
                         const CalibrationBoard& board) {
  const auto markers = board.Markers();
  std::vector<double> errors;
  for (const auto& seen : images) {
    if (const auto error = LayoutError(seen, markers)) errors.push_back(*error);
  }
  return errors.empty() ? std::numeric_limits<double>::infinity() : math::Median(errors);
}

const char* NameOf(FirstSquare first) {
  return first == FirstSquare::kMarker         ? "marker"
         : first == FirstSquare::kOpenCvLegacy ? "opencv_legacy"
                                               : "black";
}

}  // namespace

std::string ExplainLayout(const std::vector<std::vector<DetectedMarker>>& images,
                          const CalibrationBoard& board) {
  const double own = MedianLayoutError(images, board);
  if (!(own > kWrongLayoutSides) || !std::isfinite(own)) return {};
  CalibrationBoard best = board;
  double best_error = own;
  for (const bool swap : {false, true}) {
    for (const FirstSquare first : {FirstSquare::kBlack, FirstSquare::kMarker}) {
      CalibrationBoard other = board;
      if (swap) std::swap(other.columns, other.rows);
      other.first_square = first;
      const double error = MedianLayoutError(images, other);
      if (error >= best_error) continue;
      best = other;
      best_error = error;
    }
  }
  if (best_error * kBetterBy > own) {
    return "the markers do not lie as on this board: compare its columns, rows and first_square "
           "with the print";
  }
  std::string text = "the markers do not lie as on this board, but as on one of ";
  text += Message(best.columns, " columns and ", best.rows, " rows");
  if (best.columns != board.columns) text += " (rows and columns are swapped)";
  if (best.HoldsMarker(0, 0) != board.HoldsMarker(0, 0)) {
    text += Message(" with \"first_square\": \"", NameOf(best.first_square), "\"");
  }
  return text + "; change the board's file (--board)";
}

BoardViews FindBoardViews(const std::vector<std::filesystem::path>& files,
                          const CalibrationBoard& board, int least_corners,
                          const RunContext& context) {
  MarkerDetector detector(board.dictionary);
  BoardViews all;
  std::vector<std::vector<DetectedMarker>> markers;
  for (std::size_t i = 0; i < files.size(); ++i) {
    context.Checkpoint("Looking for the board",
                       static_cast<double>(i) / static_cast<double>(files.size()));
    BoardView& view = all.views.emplace_back();
    view.file = files[i].filename().string();
    const Image image = ReadImage(files[i]);
    if (all.width_px == 0) {
      all.width_px = image.width_px;
      all.height_px = image.height_px;
    }
    if (image.width_px != all.width_px || image.height_px != all.height_px) {
      view.rejected = Message("has ", image.width_px, " x ", image.height_px,
                              " pixels, the first one ", all.width_px, " x ", all.height_px);
      continue;
    }
    markers.push_back(detector.Detect(image));
    view.corners = FindBoardCorners(image, board, markers.back());
    if (static_cast<int>(view.corners.size()) < least_corners ||
        !IsSpread(view.corners, board.columns)) {
      view.rejected = Message("only ", view.corners.size(), " corners of the board; ",
                              least_corners, " are needed, in two rows and columns");
    }
  }
  const std::string explained = ExplainLayout(markers, board);
  if (!explained.empty()) throw NoAnswerError(explained);
  return all;
}

}  // namespace acus::camera
