#include "acus/scene/frame_registration/frame_similarity.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/imaging/ultrasound/aperture/aperture_renderer.h"

namespace acus::frame_registration {
namespace {

/// Windows of the simulated image with less variance count as homogeneous, in grey levels squared.
constexpr float kEvenVariance = 9.0F;

Resolution ResolutionOf(const acoustics::Probe& probe, double rows) {
  return {.pixel_mm = probe.depth_mm / rows};
}

/// The probe's image with square pixels of another size, over the same area.
acoustics::Probe WithPixels(acoustics::Probe probe, const Resolution& resolution) {
  const image::ImageGeometry full = acoustics::ImageOf(probe);
  image::ImageGeometry small;
  small.lateral_mm_per_px = small.axial_mm_per_px = resolution.pixel_mm;
  small.width_px =
      std::max(1, static_cast<int>(full.width_px * full.lateral_mm_per_px / resolution.pixel_mm));
  small.height_px =
      std::max(1, static_cast<int>(full.height_px * full.axial_mm_per_px / resolution.pixel_mm));
  small.depth_of_top_row_mm =
      full.depth_of_top_row_mm + 0.5 * (resolution.pixel_mm - full.axial_mm_per_px);
  probe.image = small;
  probe.scan_lines = resolution.scan_lines;
  probe.samples_per_line = resolution.samples_per_line;
  return probe;
}

ultrasound::ApertureOptions CheapOptions(ultrasound::ApertureOptions options, int rays) {
  options.mean_speckle = true;
  options.texture = options.noise = options.ring_down = false;
  options.elevation_planes = 1;
  options.aperture_rays = rays;
  return options;
}

/// 1 inside the area of the scan lines, and 0 near its edge and beyond.
cv::Mat FieldOfView(const acoustics::ScanGrid& grid, const image::ImageGeometry& geometry) {
  std::vector<cv::Point> outline;
  const Eigen::Affine3d px_from_mm = geometry.probe_from_image().inverse();
  const auto add = [&](int line, double depth_mm) {
    const auto n = static_cast<std::size_t>(line);
    const Eigen::Vector2d at = grid.start_mm[n] + depth_mm * grid.direction[n];
    const Eigen::Vector3d px = px_from_mm * Eigen::Vector3d(at.x(), at.y(), 0.0);
    outline.emplace_back(static_cast<int>(std::lround(px.x())),
                         static_cast<int>(std::lround(px.y())));
  };
  for (int line = 0; line < grid.lines(); ++line) add(line, 0.0);
  for (int line = grid.lines() - 1; line >= 0; --line) {
    add(line, (grid.samples - 1) * grid.step_mm);
  }
  cv::Mat inside = cv::Mat::zeros(geometry.height_px, geometry.width_px, CV_32F);
  cv::fillPoly(inside, std::vector<std::vector<cv::Point>>{outline}, cv::Scalar(1.0));
  // A blurred edge would be found in every image. The image's border is no such edge.
  cv::erode(inside, inside, cv::Mat::ones(3, 3, CV_8U));
  return inside;
}

/// The frame's grey levels in the pixels of a smaller image.
cv::Mat Resampled(const image::GrayImage& frame, const image::ImageGeometry& full,
                  const image::ImageGeometry& small) {
  const cv::Mat bytes(frame.height, frame.width, CV_8U,
                      const_cast<std::uint8_t*>(frame.pixels.data()));
  cv::Mat blurred;
  bytes.convertTo(blurred, CV_32F);
  cv::GaussianBlur(blurred, blurred, {}, small.lateral_mm_per_px / full.lateral_mm_per_px,
                   small.axial_mm_per_px / full.axial_mm_per_px);
  const Eigen::Affine3d full_from_small =
      full.probe_from_image().inverse() * small.probe_from_image();
  const cv::Matx23d map(full_from_small(0, 0), 0.0, full_from_small(0, 3), 0.0,
                        full_from_small(1, 1), full_from_small(1, 3));
  cv::Mat out;
  cv::warpAffine(blurred, out, map, {small.width_px, small.height_px},
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  return out;
}

const image::GrayImage& CheckedFrame(const image::GrayImage& frame, const acoustics::Probe& probe) {
  const image::ImageGeometry wanted = acoustics::ImageOf(probe);
  ACUS_REQUIRE(frame.width == wanted.width_px && frame.height == wanted.height_px,
               "the recorded frame has ", frame.width, " x ", frame.height,
               " pixels, the image of the probe ", wanted.width_px, " x ", wanted.height_px,
               "; give the probe preset the frame's size in pixels and mm");
  return frame;
}

}  // namespace

Resolution CoarseResolution(const acoustics::Probe& probe) {
  Resolution coarse = ResolutionOf(probe, 45.0);
  coarse.window_px = 7;
  coarse.scan_lines = 48;
  coarse.samples_per_line = 256;
  coarse.aperture_rays = 7;
  return coarse;
}

Resolution FineResolution(const acoustics::Probe& probe) {
  return ResolutionOf(probe, 90.0);
}

struct FrameSimilarity::State {
  State(const image::GrayImage& frame, const acoustics::Probe& probe,
        const SimulatedTissue& patient, const Resolution& resolution)
      : small_probe(WithPixels(probe, resolution)),
        renderer(patient.tissue, small_probe,
                 CheapOptions(patient.options, resolution.aperture_rays), 1),
        window(resolution.window_px, resolution.window_px),
        inside(FieldOfView(renderer.grid(), renderer.image())),
        recorded(Resampled(frame, acoustics::ImageOf(probe), renderer.image()).mul(inside)) {
    Box(inside, weight);
    weight = cv::max(weight, 1e-6F);
    Box(recorded, recorded_mean);
    cv::Mat square;
    Box(recorded.mul(recorded), square);
    cv::Mat variance = (square - recorded_mean.mul(recorded_mean)).mul(inside);
    variance_sum = cv::sum(variance)[0];
    ACUS_REQUIRE(variance_sum > cv::sum(inside)[0],
                 "the recorded frame has one grey inside the field of view of the probe");
  }

  /// Means over the windows' pixels in the field of view.
  void Box(const cv::Mat& in, cv::Mat& out) const {
    cv::boxFilter(in, out, CV_32F, window, {-1, -1}, true, cv::BORDER_REFLECT_101);
    if (!weight.empty()) out /= weight;
  }

  /// Sum over all windows of the variance that a rising line through the grey levels explains.
  double Explained() const {
    double sum = 0.0;
    for (int r = 0; r < inside.rows; ++r) {
      const auto* in = inside.ptr<float>(r);
      const auto* mean = simulated_mean.ptr<float>(r);
      const auto* square = simulated_square.ptr<float>(r);
      const auto* product = products.ptr<float>(r);
      const auto* other = recorded_mean.ptr<float>(r);
      for (int c = 0; c < inside.cols; ++c) {
        const float covariance = product[c] - mean[c] * other[c];
        if (covariance <= 0.0F || in[c] == 0.0F) continue;
        const float variance = std::max(0.0F, square[c] - mean[c] * mean[c]);
        sum += covariance * covariance / (variance + kEvenVariance);
      }
    }
    return sum;
  }

  acoustics::Probe small_probe;
  ultrasound::ApertureRenderer renderer;
  cv::Size window;
  cv::Mat inside;
  cv::Mat recorded;
  cv::Mat weight;  ///< Share of each window that lies in the field of view.
  cv::Mat recorded_mean;
  double variance_sum = 0.0;
  image::GrayImage image;
  cv::Mat simulated;
  cv::Mat simulated_mean;
  cv::Mat simulated_square;
  cv::Mat products;
};

FrameSimilarity::FrameSimilarity(const image::GrayImage& recorded, const acoustics::Probe& probe,
                                 const SimulatedTissue& simulated, const Resolution& resolution)
    : state_(std::make_unique<State>(CheckedFrame(recorded, probe), probe, simulated, resolution)) {
}
FrameSimilarity::~FrameSimilarity() = default;
FrameSimilarity::FrameSimilarity(FrameSimilarity&&) noexcept = default;
FrameSimilarity& FrameSimilarity::operator=(FrameSimilarity&&) noexcept = default;

double FrameSimilarity::At(const Eigen::Isometry3d& ct_from_probe) {
  State& s = *state_;
  s.renderer.Render(ct_from_probe, {}, s.image, 1);
  const cv::Mat bytes(s.image.height, s.image.width, CV_8U, s.image.pixels.data());
  bytes.convertTo(s.simulated, CV_32F);
  cv::GaussianBlur(s.simulated, s.simulated, {}, 1.0);
  s.simulated = s.simulated.mul(s.inside);
  s.Box(s.simulated, s.simulated_mean);
  s.Box(s.simulated.mul(s.simulated), s.simulated_square);
  s.Box(s.simulated.mul(s.recorded), s.products);
  return std::clamp(s.Explained() / s.variance_sum, 0.0, 1.0);
}

double FrameSimilarity::independent_values() const {
  return cv::sum(state_->inside)[0] / (4.0 * std::numbers::pi);
}

}  // namespace acus::frame_registration
