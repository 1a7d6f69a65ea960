#include "acus/rig/camera/board_views.h"

#include <algorithm>
#include <array>
#include <opencv2/calib3d.hpp>
#include <optional>
#include <set>

#include "acus/base/core/error.h"
#include "acus/base/math/statistics.h"

namespace acus::camera {
namespace {

/// Farther than this from where the other markers put it, in sides of a marker, a marker is
/// misread: that moves it by whole squares, the distortion of an endoscope by a third of a side.
constexpr double kMisreadSides = 0.6;
/// The layout is right if so many markers lie as on the board: up to 14 % misread were seen.
constexpr double kRightShare = 0.75;
constexpr double kBetterBy = 0.15;  ///< Share by which another layout fits better.
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

/// Which of the markers lie as on the board, by a homography that most of them agree on. Nothing if
/// fewer than four markers of the board were seen.
std::optional<std::vector<bool>> FittingMarkers(const std::vector<DetectedMarker>& seen,
                                                const std::vector<Marker>& markers) {
  std::vector<cv::Point2f> from, to;
  std::vector<std::size_t> which;
  double side_px = 0.0;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen[i].id < 0 || seen[i].id >= static_cast<int>(markers.size())) continue;
    which.push_back(i);
    const auto corners = markers[static_cast<std::size_t>(seen[i].id)].CornersInObjectMm();
    for (std::size_t k = 0; k < 4; ++k) {
      from.emplace_back(static_cast<float>(corners[k][0]), static_cast<float>(corners[k][1]));
      to.emplace_back(static_cast<float>(seen[i].corners_px[k][0]),
                      static_cast<float>(seen[i].corners_px[k][1]));
      side_px += (seen[i].corners_px[(k + 1) % 4] - seen[i].corners_px[k]).norm();
    }
  }
  if (which.size() < kLeastMarkers) return std::nullopt;
  side_px /= static_cast<double>(from.size());
  const double limit_px = kMisreadSides * side_px;
  std::vector<bool> fits(seen.size(), false);
  const cv::Mat map = cv::findHomography(from, to, cv::RANSAC, limit_px);
  if (map.empty()) return fits;
  std::vector<cv::Point2f> mapped;
  cv::perspectiveTransform(from, mapped, map);
  for (std::size_t m = 0; m < which.size(); ++m) {
    double off_px = 0.0;
    for (std::size_t k = 4 * m; k < 4 * m + 4; ++k) off_px += cv::norm(mapped[k] - to[k]) / 4.0;
    fits[which[m]] = off_px <= limit_px;
  }
  return fits;
}

/// Share of the markers that lie as on the board: median over the images that show enough.
double FittingShare(const std::vector<std::vector<DetectedMarker>>& images,
                    const CalibrationBoard& board) {
  const auto markers = board.Markers();
  std::vector<double> shares;
  for (const auto& seen : images) {
    if (const auto fits = FittingMarkers(seen, markers)) {
      shares.push_back(static_cast<double>(std::ranges::count(*fits, true)) /
                       static_cast<double>(fits->size()));
    }
  }
  return shares.empty() ? 1.0 : math::Median(shares);
}

const char* NameOf(FirstSquare first) {
  return first == FirstSquare::kMarker         ? "marker"
         : first == FirstSquare::kOpenCvLegacy ? "opencv_legacy"
                                               : "black";
}

}  // namespace

std::vector<DetectedMarker> WithoutMisread(const std::vector<DetectedMarker>& seen,
                                           const CalibrationBoard& board) {
  const auto fits = FittingMarkers(seen, board.Markers());
  if (!fits) return seen;
  std::vector<DetectedMarker> read;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if ((*fits)[i]) read.push_back(seen[i]);
  }
  return read;
}

std::string ExplainLayout(const std::vector<std::vector<DetectedMarker>>& images,
                          const CalibrationBoard& board) {
  const double own = FittingShare(images, board);
  if (own >= kRightShare) return {};
  CalibrationBoard best = board;
  double best_share = own;
  for (const bool swap : {false, true}) {
    for (const FirstSquare first : {FirstSquare::kBlack, FirstSquare::kMarker}) {
      CalibrationBoard other = board;
      if (swap) std::swap(other.columns, other.rows);
      other.first_square = first;
      const double share = FittingShare(images, other);
      if (share <= best_share) continue;
      best = other;
      best_share = share;
    }
  }
  if (best_share < own + kBetterBy) {
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
    const std::vector<DetectedMarker> read = WithoutMisread(markers.back(), board);
    view.misread = static_cast<int>(markers.back().size() - read.size());
    view.corners = FindBoardCorners(image, board, read);
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
