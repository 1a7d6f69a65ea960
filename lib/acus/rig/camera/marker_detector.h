// Finds square markers in an image, with corners to a few hundredths of a pixel.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "acus/rig/camera/camera_model.h"
#include "acus/rig/camera/image.h"

namespace acus::camera {

struct DetectedMarker {
  int id = 0;
  /// Top left, top right, bottom right, bottom left as printed; pixels.
  std::array<Eigen::Vector2d, 4> corners_px;
  /// Standard deviation of each corner, pixels, from how well its two edges are seen.
  std::array<double, 4> sigma_px{};
};

struct DetectorSettings {
  /// Shorter sides are not looked for, pixels.
  double smallest_side_px = 12.0;
  /// Half of the length over which an edge is looked for across it, pixels.
  double search_px = 4.0;
  /// 2: outlines are looked for in an image of twice the size, for markers of about 10 px a side.
  int magnification = 1;
};

class MarkerDetector {
 public:
  /// @throws InputError for a dictionary that does not exist.
  explicit MarkerDetector(const std::string& dictionary, const DetectorSettings& settings = {});
  ~MarkerDetector();
  MarkerDetector(MarkerDetector&&) noexcept;
  MarkerDetector& operator=(MarkerDetector&&) noexcept;

  /// All markers of the dictionary in a grey or colour image, ordered by id, then by place. The
  /// same id twice is reported twice. Corners are where lines through the four edges meet; with a
  /// camera these lines are straight in its rays, not in the image. Deterministic; not for two
  /// threads at a time.
  std::vector<DetectedMarker> Detect(const Image& image, const CameraModel* camera = nullptr);

 private:
  struct Content;
  std::unique_ptr<Content> content_;
};

}  // namespace acus::camera
