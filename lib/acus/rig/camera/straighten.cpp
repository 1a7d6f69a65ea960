#include "acus/rig/camera/straighten.h"

#include <opencv2/imgproc.hpp>

#include "acus/base/core/error.h"
#include "acus/rig/camera/opencv_image.h"

namespace acus::camera {

struct Straightener::Map {
  explicit Map(const CameraModel& camera) : straight(camera.Pinhole()) {}
  CameraModel straight;
  cv::Mat columns, rows;  ///< Where in the image each pixel comes from; empty: the same place.
};

Straightener::Straightener(const CameraModel& camera) : map_(std::make_unique<Map>(camera)) {
  HoldOpenCvToOneThread();
  if (!camera.has_distortion()) return;
  const CameraParameters& p = camera.parameters();
  map_->columns.create(p.height_px, p.width_px, CV_32FC1);
  map_->rows.create(p.height_px, p.width_px, CV_32FC1);
  for (int row = 0; row < p.height_px; ++row) {
    for (int column = 0; column < p.width_px; ++column) {
      const auto ray = map_->straight.Ray({column, row});
      const auto from = ray ? camera.Project(1000.0 * *ray) : std::nullopt;
      map_->columns.at<float>(row, column) = from ? static_cast<float>((*from)[0]) : -10.0F;
      map_->rows.at<float>(row, column) = from ? static_cast<float>((*from)[1]) : -10.0F;
    }
  }
}

Straightener::~Straightener() = default;
Straightener::Straightener(Straightener&&) noexcept = default;
Straightener& Straightener::operator=(Straightener&&) noexcept = default;

const CameraModel& Straightener::pinhole() const {
  return map_->straight;
}

void Straightener::Straighten(const Image& image, Image& out) const {
  const CameraParameters& p = map_->straight.parameters();
  ACUS_REQUIRE(image.width_px == p.width_px && image.height_px == p.height_px, "the image has ",
               image.width_px, " x ", image.height_px, " pixels, the camera's file says ",
               p.width_px, " x ", p.height_px, "; calibrate at the size that is used");
  if (map_->columns.empty()) {
    out = image;
    return;
  }
  out.Resize(image.width_px, image.height_px, image.channels);
  out.time_ns = image.time_ns;
  cv::Mat to = MatOf(out);
  cv::remap(MatOf(image), to, map_->columns, map_->rows, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
}

}  // namespace acus::camera
