#include "acus/rig/camera/corner_refinement.h"

#include <algorithm>
#include <cmath>

#include "acus/rig/camera/edge_fit.h"

namespace acus::camera {
namespace {

constexpr double kUnrefinedSigmaPx = 0.7;
constexpr double kLargestChangePx = 3.0;
constexpr double kLeastReachPx = 1.3;
constexpr double kBlurPx = 1.5;  ///< How far a step reaches in an image in focus.
/// Share of the side, at both ends: there the other edges show.
constexpr double kLeftOut = 0.08;

/// Pixels of the image to those of a pinhole at the same place, where edges are straight.
class PinholePixels {
 public:
  explicit PinholePixels(const CameraModel* camera)
      : camera_(camera != nullptr && camera->has_distortion() ? camera : nullptr) {}
  std::optional<Eigen::Vector2d> Straight(const Eigen::Vector2d& pixel) const {
    if (camera_ == nullptr) return pixel;
    const auto ray = camera_->Ray(pixel);
    if (!ray) return std::nullopt;
    return camera_->parameters().focal_px.cwiseProduct(ray->head<2>()) +
           camera_->parameters().centre_px;
  }
  std::optional<Eigen::Vector2d> Seen(const Eigen::Vector2d& straight) const {
    if (camera_ == nullptr) return straight;
    const Eigen::Vector2d slope =
        (straight - camera_->parameters().centre_px).cwiseQuotient(camera_->parameters().focal_px);
    return camera_->Project(1000.0 * slope.homogeneous());
  }

 private:
  const CameraModel* camera_;
};

struct Line {
  Eigen::Vector2d point;
  Eigen::Vector2d direction;
  Eigen::Matrix2d covariance;  ///< Of its offset (px) at `point` and its slope.
  bool refined = false;

  /// Variance across the line at a distance along it, px^2.
  double VarianceAt(double along_px) const {
    const Eigen::Vector2d row(1.0, along_px);
    return row.dot(covariance * row);
  }
};

/// Pixels within `reach` of the side from a to b, in its frame: along from its middle, across
/// towards the outside.
std::vector<EdgePixel> Collect(const Image& grey, const PinholePixels& pinhole,
                               const Eigen::Vector2d& a, const Eigen::Vector2d& b, double reach) {
  std::vector<EdgePixel> pixels;
  const Eigen::Vector2d middle = 0.5 * (a + b);
  const double length = (b - a).norm();
  const Eigen::Vector2d along = (b - a) / length;
  // Corners run clockwise as seen, rows grow downwards: outside is to the left of the outline.
  const Eigen::Vector2d out(along[1], -along[0]);
  // The lens moves pixels by less than this between the image and the pinhole, per pixel.
  const double margin = reach + 2.0;
  const double half = (0.5 - kLeftOut) * length;
  const auto seen_a = pinhole.Seen(a);
  const auto seen_b = pinhole.Seen(b);
  if (!seen_a || !seen_b) return pixels;
  const Eigen::Vector2d low = seen_a->cwiseMin(*seen_b);
  const Eigen::Vector2d high = seen_a->cwiseMax(*seen_b);
  const Eigen::Vector2d seen_along = (*seen_b - *seen_a).normalized();
  const int left = std::max(0, static_cast<int>(std::floor(low[0] - margin)));
  const int right = std::min(grey.width_px - 1, static_cast<int>(std::ceil(high[0] + margin)));
  const int top = std::max(0, static_cast<int>(std::floor(low[1] - margin)));
  const int bottom = std::min(grey.height_px - 1, static_cast<int>(std::ceil(high[1] + margin)));
  for (int row = top; row <= bottom; ++row) {
    for (int column = left; column <= right; ++column) {
      const Eigen::Vector2d seen(column, row);
      const Eigen::Vector2d from_a = seen - *seen_a;
      if (std::abs(from_a[0] * seen_along[1] - from_a[1] * seen_along[0]) > margin) continue;
      const auto straight = pinhole.Straight(seen);
      if (!straight) continue;
      const Eigen::Vector2d from_middle = *straight - middle;
      const double t = from_middle.dot(along);
      const double d = from_middle.dot(out);
      if (std::abs(t) > half || std::abs(d) > reach) continue;
      pixels.push_back(
          {t, d,
           static_cast<double>(
               grey.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(grey.width_px) +
                           static_cast<std::size_t>(column)])});
    }
  }
  return pixels;
}

Line FindLine(const Image& grey, const PinholePixels& pinhole, const Eigen::Vector2d& a,
              const Eigen::Vector2d& b, double reach) {
  Line line{.point = 0.5 * (a + b),
            .direction = (b - a).normalized(),
            .covariance = Eigen::Matrix2d::Identity() * kUnrefinedSigmaPx * kUnrefinedSigmaPx,
            .refined = false};
  line.covariance(1, 1) = 0.0;
  // A second time with the strip centred on the edge, if it was not.
  for (int pass = 0; pass < 2; ++pass) {
    const double length = (b - a).norm();
    const Eigen::Vector2d from = line.point - 0.5 * length * line.direction;
    const auto pixels = Collect(grey, pinhole, from, from + length * line.direction, reach);
    const auto fit = FitEdge(pixels, reach);
    if (!fit) return line;
    const Eigen::Vector2d out(line.direction[1], -line.direction[0]);
    line.point += fit->offset_px * out;
    line.direction = (line.direction + fit->slope * out).normalized();
    line.covariance = fit->covariance;
    line.refined = true;
    if (std::abs(fit->offset_px) + 0.5 * length * std::abs(fit->slope) < 0.5) break;
  }
  return line;
}

std::optional<Eigen::Vector2d> Meet(const Line& a, const Line& b) {
  const double cross = a.direction[0] * b.direction[1] - a.direction[1] * b.direction[0];
  if (std::abs(cross) < 0.05) return std::nullopt;  // Within 3 degrees of parallel.
  const Eigen::Vector2d between = b.point - a.point;
  const double t = (between[0] * b.direction[1] - between[1] * b.direction[0]) / cross;
  return a.point + t * a.direction;
}

double SigmaAt(const Line& a, const Line& b, const Eigen::Vector2d& corner) {
  const double cross = a.direction[0] * b.direction[1] - a.direction[1] * b.direction[0];
  const double sum = a.VarianceAt((corner - a.point).dot(a.direction)) +
                     b.VarianceAt((corner - b.point).dot(b.direction));
  return std::sqrt(0.5 * sum) / std::abs(cross);
}

}  // namespace

void RefineCorners(const Image& grey, int modules, double search_px, const CameraModel* camera,
                   DetectedMarker& marker) {
  const PinholePixels pinhole(camera);
  marker.sigma_px.fill(kUnrefinedSigmaPx);
  std::array<Eigen::Vector2d, 4> straight;
  double shortest = 1e9;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto corner = pinhole.Straight(marker.corners_px[i]);
    if (!corner) return;
    straight[i] = *corner;
  }
  for (std::size_t i = 0; i < 4; ++i) {
    shortest = std::min(shortest, (straight[(i + 1) % 4] - straight[i]).norm());
  }
  // Up to where the next module's white begins to shine in.
  const double module = shortest / modules;
  const double reach =
      std::min(search_px, std::max({module - kBlurPx, 0.5 * module, kLeastReachPx}));
  std::array<Line, 4> lines;
  for (std::size_t i = 0; i < 4; ++i) {
    lines[i] = FindLine(grey, pinhole, straight[i], straight[(i + 1) % 4], reach);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const Line& before = lines[(i + 3) % 4];
    const Line& after = lines[i];
    const auto meet = Meet(before, after);
    if (!meet || (*meet - straight[i]).norm() > kLargestChangePx) continue;
    const auto seen = pinhole.Seen(*meet);
    if (!seen) continue;
    marker.corners_px[i] = *seen;
    marker.sigma_px[i] = before.refined && after.refined
                             ? std::min(kUnrefinedSigmaPx, SigmaAt(before, after, *meet))
                             : kUnrefinedSigmaPx;
  }
}

}  // namespace acus::camera
