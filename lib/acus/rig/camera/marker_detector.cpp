#include "acus/rig/camera/marker_detector.h"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "acus/base/core/error.h"
#include "acus/rig/camera/corner_refinement.h"
#include "acus/rig/camera/opencv_image.h"

namespace acus::camera {

namespace {

/// Codes of fewer bits turn up in any clutter.
constexpr int kLeastBitsForSecondLook = 5;

double Bilinear(const Image& grey, const Eigen::Vector2d& at) {
  const double column = std::clamp(at[0], 0.0, grey.width_px - 1.001);
  const double row = std::clamp(at[1], 0.0, grey.height_px - 1.001);
  const auto c = static_cast<int>(column);
  const auto r = static_cast<int>(row);
  const double u = column - c;
  const double v = row - r;
  const std::uint8_t* level =
      grey.pixels.data() + static_cast<std::ptrdiff_t>(r) * grey.width_px + c;
  return (1.0 - v) * ((1.0 - u) * level[0] + u * level[1]) +
         v * ((1.0 - u) * level[grey.width_px] + u * level[grey.width_px + 1]);
}

/// Projective map from the unit square (0, 0), (1, 0), (1, 1), (0, 1) to four corners.
std::optional<Eigen::Matrix3d> FromUnitSquare(const std::array<Eigen::Vector2d, 4>& corner) {
  const Eigen::Vector2d a = corner[1] - corner[2];
  const Eigen::Vector2d b = corner[3] - corner[2];
  const Eigen::Vector2d s = corner[0] - corner[1] + corner[2] - corner[3];
  const double determinant = a[0] * b[1] - a[1] * b[0];
  if (std::abs(determinant) < 1e-6) return std::nullopt;
  const double g = (s[0] * b[1] - s[1] * b[0]) / determinant;
  const double h = (a[0] * s[1] - a[1] * s[0]) / determinant;
  Eigen::Matrix3d map;
  map << (1.0 + g) * corner[1] - corner[0], (1.0 + h) * corner[3] - corner[0], corner[0], g, h, 1.0;
  return map;
}

/// Mean level of each module, the black border included; row by row.
std::vector<double> ModuleLevels(const Image& grey, const Eigen::Matrix3d& from_unit, int modules) {
  constexpr int kSamples = 3;  // Each way, in the middle of the module.
  std::vector<double> levels;
  for (int row = 0; row < modules; ++row) {
    for (int column = 0; column < modules; ++column) {
      double sum = 0.0;
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const double x = (column + 0.3 + 0.2 * (s % kSamples)) / modules;
        const double y = (row + 0.3 + 0.2 * (s / kSamples)) / modules;
        sum += Bilinear(grey, (from_unit * Eigen::Vector3d(x, y, 1.0)).hnormalized());
      }
      levels.push_back(sum / (kSamples * kSamples));
    }
  }
  return levels;
}

/// Reads the code between corners that are already exact. Every bit must be right, and the border
/// black. Turns the corners to the marker's own top left.
bool Decode(const Image& grey, const cv::aruco::Dictionary& dictionary, DetectedMarker& marker) {
  const int bits = dictionary.markerSize;
  const int modules = bits + 2;
  const auto from_unit = FromUnitSquare(marker.corners_px);
  if (!from_unit) return false;
  const std::vector<double> levels = ModuleLevels(grey, *from_unit, modules);
  const auto [low, high] = std::minmax_element(levels.begin(), levels.end());
  const double threshold = 0.5 * (*low + *high);
  if (*high - *low < 20.0) return false;
  cv::Mat code(bits, bits, CV_8UC1);
  int white_border = 0;
  for (int row = 0; row < modules; ++row) {
    for (int column = 0; column < modules; ++column) {
      const bool white = levels[static_cast<std::size_t>(row * modules + column)] > threshold;
      if (row == 0 || column == 0 || row == modules - 1 || column == modules - 1) {
        white_border += white ? 1 : 0;
      } else {
        code.at<unsigned char>(row - 1, column - 1) = white ? 1 : 0;
      }
    }
  }
  int turns = 0;
  if (white_border > 0 || !dictionary.identify(code, marker.id, turns, 0.0)) return false;
  const auto shift = static_cast<std::ptrdiff_t>((4 - turns) % 4);
  std::rotate(marker.corners_px.begin(), marker.corners_px.begin() + shift,
              marker.corners_px.end());
  std::rotate(marker.sigma_px.begin(), marker.sigma_px.begin() + shift, marker.sigma_px.end());
  return true;
}

Eigen::Vector2d Middle(const DetectedMarker& marker) {
  return 0.25 * (marker.corners_px[0] + marker.corners_px[1] + marker.corners_px[2] +
                 marker.corners_px[3]);
}

/// The inner and outer outline of one marker, or two looks at it, count once.
void KeepOneOfEach(std::vector<DetectedMarker>& found) {
  std::vector<DetectedMarker> kept;
  for (const DetectedMarker& marker : found) {
    const double side = (marker.corners_px[1] - marker.corners_px[0]).norm();
    const auto same = std::find_if(kept.begin(), kept.end(), [&](const DetectedMarker& other) {
      return other.id == marker.id && (Middle(other) - Middle(marker)).norm() < 0.5 * side;
    });
    if (same == kept.end()) {
      kept.push_back(marker);
    } else if (marker.sigma_px[0] + marker.sigma_px[2] < same->sigma_px[0] + same->sigma_px[2]) {
      *same = marker;
    }
  }
  found = std::move(kept);
}

}  // namespace

struct MarkerDetector::Content {
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::DetectorParameters> parameters = cv::aruco::DetectorParameters::create();
  DetectorSettings settings;
  Image grey;
  cv::Mat magnified;

  cv::Mat Magnified() {
    if (settings.magnification == 1) return MatOf(grey);
    cv::resize(MatOf(grey), magnified, {}, settings.magnification, settings.magnification,
               cv::INTER_CUBIC);
    return magnified;
  }
};

MarkerDetector::MarkerDetector(const std::string& dictionary, const DetectorSettings& settings)
    : content_(std::make_unique<Content>()) {
  ACUS_REQUIRE(settings.smallest_side_px >= 4.0 && settings.smallest_side_px <= 1000.0,
               "marker detector: smallest side ", settings.smallest_side_px,
               " px; allowed is 4 to 1000");
  ACUS_REQUIRE(settings.search_px >= 1.0 && settings.search_px <= 20.0, "marker detector: search ",
               settings.search_px, " px; allowed is 1 to 20");
  ACUS_REQUIRE(settings.magnification == 1 || settings.magnification == 2,
               "marker detector: magnification ", settings.magnification, "; allowed are 1 and 2");
  HoldOpenCvToOneThread();
  content_->dictionary = cv::aruco::getPredefinedDictionary(OpenCvDictionary(dictionary));
  content_->settings = settings;
  // Neighbours on a sheet are not one marker seen twice.
  content_->parameters->minMarkerDistanceRate = 0.02;
  content_->parameters->perspectiveRemovePixelPerCell = 8;
  content_->parameters->perspectiveRemoveIgnoredMarginPerCell = 0.33;
}

MarkerDetector::~MarkerDetector() = default;
MarkerDetector::MarkerDetector(MarkerDetector&&) noexcept = default;
MarkerDetector& MarkerDetector::operator=(MarkerDetector&&) noexcept = default;

std::vector<DetectedMarker> MarkerDetector::Detect(const Image& image, const CameraModel* camera) {
  std::vector<DetectedMarker> found;
  if (image.empty() || std::min(image.width_px, image.height_px) < 16) return found;
  ToGrey(image, content_->grey);
  const Image& grey = content_->grey;
  content_->parameters->minMarkerPerimeterRate =
      4.0 * content_->settings.smallest_side_px / std::max(grey.width_px, grey.height_px);
  std::vector<std::vector<cv::Point2f>> corners, rejected;
  std::vector<int> ids;
  try {
    cv::aruco::detectMarkers(content_->Magnified(), content_->dictionary, corners, ids,
                             content_->parameters, rejected);
  } catch (const cv::Exception&) {
    return {};  // OpenCV asserts on some degenerate quadrangles: then there is no marker.
  }
  const auto refined = [&](const std::vector<cv::Point2f>& at, const CameraModel* lens) {
    DetectedMarker marker;
    const double factor = content_->settings.magnification;
    for (std::size_t k = 0; k < 4; ++k) {
      // Pixel c became the pixels factor * c ... factor * c + factor - 1.
      const Eigen::Vector2d magnified(at[k].x, at[k].y);
      marker.corners_px[k] = ((magnified.array() + 0.5) / factor - 0.5).matrix();
    }
    RefineCorners(grey, content_->dictionary->markerSize + 2, content_->settings.search_px, lens,
                  marker);
    return marker;
  };
  for (std::size_t i = 0; i < ids.size(); ++i) {
    found.push_back(refined(corners[i], camera));
    found.back().id = ids[i];
  }
  // The outlines that OpenCV could not read were often only off by a pixel or two.
  for (const std::vector<cv::Point2f>& outline : rejected) {
    if (content_->dictionary->markerSize < kLeastBitsForSecondLook) break;
    DetectedMarker marker = refined(outline, camera);
    const double worst = *std::max_element(marker.sigma_px.begin(), marker.sigma_px.end());
    if (worst < 0.5 && Decode(grey, *content_->dictionary, marker)) found.push_back(marker);
  }
  KeepOneOfEach(found);
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    if (a.id != b.id) return a.id < b.id;
    return std::pair(a.corners_px[0][1], a.corners_px[0][0]) <
           std::pair(b.corners_px[0][1], b.corners_px[0][0]);
  });
  return found;
}

}  // namespace acus::camera
