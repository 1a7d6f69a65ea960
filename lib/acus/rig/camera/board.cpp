#include "acus/rig/camera/board.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/rig/camera/opencv_image.h"

namespace acus::camera {
namespace {

using nlohmann::json;

/// Where a point of the board is, by the homography of one marker near it.
std::optional<Eigen::Vector2d> ByMarker(const Marker& marker, const DetectedMarker& seen,
                                        const Eigen::Vector3d& point_mm) {
  std::vector<cv::Point2f> from, to;
  const auto corners = marker.CornersInObjectMm();
  for (std::size_t k = 0; k < 4; ++k) {
    from.emplace_back(static_cast<float>(corners[k][0]), static_cast<float>(corners[k][1]));
    to.emplace_back(static_cast<float>(seen.corners_px[k][0]),
                    static_cast<float>(seen.corners_px[k][1]));
  }
  const cv::Mat map = cv::getPerspectiveTransform(from, to);
  Eigen::Matrix3d homography;
  for (int i = 0; i < 9; ++i) homography(i / 3, i % 3) = map.at<double>(i / 3, i % 3);
  const Eigen::Vector3d at = homography * point_mm.head<2>().homogeneous();
  if (!(std::abs(at[2]) > 1e-9)) return std::nullopt;
  return at.hnormalized();
}

struct Guess {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  double square_px = 1e9;
};

/// Each corner from the one or two markers that touch its squares.
std::map<std::size_t, Guess> GuessCorners(const CalibrationBoard& board,
                                          const std::vector<DetectedMarker>& seen) {
  const std::vector<Marker> markers = board.Markers();
  const std::vector<Eigen::Vector3d> corners = board.CornersMm();
  std::map<std::size_t, Guess> guesses;
  for (const DetectedMarker& detected : seen) {
    if (detected.id >= static_cast<int>(markers.size())) continue;
    const Marker& marker = markers[static_cast<std::size_t>(detected.id)];
    double side_px = 1e9;
    for (std::size_t k = 0; k < 4; ++k) {
      side_px =
          std::min(side_px, (detected.corners_px[(k + 1) % 4] - detected.corners_px[k]).norm());
    }
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector3d off = corners[i] - marker.object_from_marker.translation();
      if (off.cwiseAbs().maxCoeff() > 0.51 * board.square_mm) continue;
      const auto at = ByMarker(marker, detected, corners[i]);
      if (!at) continue;
      Guess& guess = guesses[i];
      guess.sum += *at;
      ++guess.count;
      guess.square_px = std::min(guess.square_px, side_px * board.square_mm / marker.side_mm);
    }
  }
  return guesses;
}

}  // namespace

bool CalibrationBoard::HoldsMarker(int column, int row) const {
  const bool first = first_square == FirstSquare::kMarker ||
                     (first_square == FirstSquare::kOpenCvLegacy && rows % 2 == 0);
  return (column + row) % 2 == (first ? 0 : 1);
}

double CalibrationBoard::ModuleMm() const {
  const auto bits = static_cast<double>(MarkerBits(dictionary, 0).size());
  return square_mm / (bits + 2.0 + 2.0 * quiet_modules);
}

double CalibrationBoard::MarkerMm() const {
  if (marker_mm > 0.0) return marker_mm;
  return square_mm - 2.0 * quiet_modules * ModuleMm();
}

std::vector<std::vector<bool>> CalibrationBoard::Modules() const {
  ACUS_REQUIRE(marker_mm == 0.0, "board '", name,
               "' was printed by another program (marker_mm is given), print it there; or take "
               "quiet_modules in place of marker_mm");
  const auto per_square =
      MarkerBits(dictionary, 0).size() + 2 + 2 * static_cast<std::size_t>(quiet_modules);
  std::vector<std::vector<bool>> out(
      static_cast<std::size_t>(rows) * per_square,
      std::vector<bool>(static_cast<std::size_t>(columns) * per_square));
  int id = 0;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (!HoldsMarker(column, row)) continue;
      const auto code = MarkerBits(dictionary, id++);
      const auto border = static_cast<std::size_t>(quiet_modules);
      for (std::size_t y = 0; y < per_square; ++y) {
        for (std::size_t x = 0; x < per_square; ++x) {
          const bool quiet = std::min({x, y, per_square - 1 - x, per_square - 1 - y}) < border;
          const bool in_code = std::min({x, y, per_square - 1 - x, per_square - 1 - y}) > border;
          out[static_cast<std::size_t>(row) * per_square + y]
             [static_cast<std::size_t>(column) * per_square + x] =
                 quiet || (in_code && code[y - border - 1][x - border - 1]);
        }
      }
    }
  }
  return out;
}

std::vector<Marker> CalibrationBoard::Markers() const {
  std::vector<Marker> markers;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if (!HoldsMarker(column, row)) continue;
      Marker marker;
      marker.id = static_cast<int>(markers.size());
      marker.side_mm = MarkerMm();
      marker.object_from_marker = Eigen::Translation3d(square_mm * (column - 0.5 * (columns - 1)),
                                                       square_mm * (0.5 * (rows - 1) - row), 0.0);
      marker.facet = name;
      markers.push_back(marker);
    }
  }
  return markers;
}

std::vector<Eigen::Vector3d> CalibrationBoard::CornersMm() const {
  std::vector<Eigen::Vector3d> corners;
  for (int row = 1; row < rows; ++row) {
    for (int column = 1; column < columns; ++column) {
      corners.emplace_back(square_mm * (column - 0.5 * columns), square_mm * (0.5 * rows - row),
                           0.0);
    }
  }
  return corners;
}

CalibrationBoard ReadBoard(const std::filesystem::path& path) {
  const json document = config::ReadConfig(path, "acus-camera-board");
  CalibrationBoard board;
  board.name = document.at("name");
  board.dictionary = document.at("dictionary");
  board.columns = document.at("columns");
  board.rows = document.at("rows");
  board.square_mm = document.at("square_mm");
  static const std::map<std::string, FirstSquare> kFirst = {
      {"black", FirstSquare::kBlack},
      {"marker", FirstSquare::kMarker},
      {"opencv_legacy", FirstSquare::kOpenCvLegacy}};
  board.first_square = kFirst.at(document.at("first_square"));
  board.quiet_modules = document.at("quiet_modules");
  board.marker_mm = document.value("marker_mm", 0.0);
  ACUS_REQUIRE(board.marker_mm < board.square_mm, path.string(), ": marker_mm is ", board.marker_mm,
               ", its square ", board.square_mm, " mm; it must be smaller");
  board.paper_mm = {document.at("paper_mm").at(0).get<double>(),
                    document.at("paper_mm").at(1).get<double>()};
  const int needed = (board.columns * board.rows + (board.HoldsMarker(0, 0) ? 1 : 0)) / 2;
  const int size = DictionarySize(board.dictionary);
  ACUS_REQUIRE(needed <= size, path.string(), ": ", board.columns, " x ", board.rows,
               " squares need ", needed, " markers, ", board.dictionary, " has ", size,
               "; take a larger dictionary or fewer squares");
  if (board.marker_mm > 0.0) return board;
  constexpr double kRoomMm = 12.0;  // For the ruler and words below it.
  ACUS_REQUIRE(board.columns * board.square_mm + kRoomMm <= board.paper_mm[0] &&
                   board.rows * board.square_mm + 2.0 * kRoomMm <= board.paper_mm[1],
               path.string(), ": the board of ", board.columns * board.square_mm, " x ",
               board.rows * board.square_mm, " mm does not fit on paper of ", board.paper_mm[0],
               " x ", board.paper_mm[1], " mm with ", kRoomMm, " mm around it");
  return board;
}

std::vector<BoardCorner> FindBoardCorners(const Image& image, const CalibrationBoard& board,
                                          MarkerDetector& detector) {
  Image grey;
  ToGrey(image, grey);
  return FindBoardCorners(grey, board, detector.Detect(grey));
}

std::vector<BoardCorner> FindBoardCorners(const Image& image, const CalibrationBoard& board,
                                          const std::vector<DetectedMarker>& seen) {
  Image grey;
  ToGrey(image, grey);
  std::vector<BoardCorner> found;
  if (seen.size() < 2) return found;
  for (const auto& [number, guess] : GuessCorners(board, seen)) {
    const Eigen::Vector2d start = guess.sum / guess.count;
    // The window must hold the corner alone: not the marker's black, a module further in.
    const int half = std::clamp(static_cast<int>(0.12 * guess.square_px), 2, 8);
    const double margin = half + 2.0;
    if (start[0] < margin || start[1] < margin || start[0] > image.width_px - 1 - margin ||
        start[1] > image.height_px - 1 - margin) {
      continue;
    }
    std::vector<cv::Point2f> at = {{static_cast<float>(start[0]), static_cast<float>(start[1])}};
    cv::cornerSubPix(MatOf(grey), at, {half, half}, {-1, -1},
                     {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 50, 1e-3});
    const Eigen::Vector2d refined(at[0].x, at[0].y);
    if ((refined - start).norm() > half) continue;
    found.push_back({number, refined});
  }
  return found;
}

}  // namespace acus::camera
