#include "acus/patient/registration/probe_calibration.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <set>

#include "acus/base/core/error.h"
#include "acus/base/math/distributions.h"
#include "acus/patient/registration/error_bound.h"
#include "acus/patient/registration/image_plane_fit.h"

namespace acus::registration {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kLeastImages = 10;  ///< As PLUS has it.
constexpr double kLeastSpread = 0.01;     ///< Of the points across their main axis, over along it.
/// Points that move by less than this in mm, as an image moves by 1 mm at its corners, do not
/// determine the motion.
constexpr double kLeastConstraint = 0.02;
constexpr double kFewestUsed = 0.6;
constexpr double kFinestMmPerPx = 0.002;
constexpr double kCoarsestMmPerPx = 2.0;

/// Refuses pixels on a line: they determine no scale across it.
void RequireSpread(const std::vector<Vector2d>& points_px, const char* what_to_add) {
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& point : points_px) mean += point;
  mean /= static_cast<double>(points_px.size());
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (const Vector2d& point : points_px) covariance += (point - mean) * (point - mean).transpose();
  const Vector2d spread =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(covariance).eigenvalues().cwiseMax(0.0);
  if (spread[0] > kLeastSpread * kLeastSpread * spread[1]) return;
  throw NoAnswerError(Message("the points lie on a line in the image (their spread across it is ",
                              100.0 * std::sqrt(spread[0] / std::max(1e-300, spread[1])),
                              " % of that along it, at least ", 100.0 * kLeastSpread,
                              " % are needed): ", what_to_add));
}

std::vector<Vector2d> CornersPx(const Vector2d& size_px) {
  return {{0.0, 0.0}, {size_px.x(), 0.0}, {0.0, size_px.y()}, size_px};
}

/// What to record where a motion of the image is not determined, by its largest part.
const char* Remedy(const PlaneVector& motion, const ImagePlane& plane, const Vector2d& size_px) {
  const Vector3d turn = plane.axes.transpose() * motion.segment<3>(3);
  const double width_mm = plane.mm_per_px.x() * size_px.x();
  const double height_mm = plane.mm_per_px.y() * size_px.y();
  const double columns = std::abs(motion[6]) * size_px.x();
  const double rows = std::abs(motion[7]) * size_px.y();
  const double out = std::hypot(turn.x() * height_mm, turn.y() * width_mm);
  const double shift = motion.head<3>().norm();
  if (std::max(columns, rows) > std::max(out, shift)) {
    return columns > rows
               ? "the scale along the columns is open; add images that show the points farther to "
                 "the left and to the right"
               : "the scale along the rows is open; add images that show the points at other "
                 "depths";
  }
  return "how the image is tilted or shifted out of its plane is open; add images with the probe "
         "turned and tilted, in which the points lie at other depths and sides";
}

/// RMS motion of the points in mm for the worst motion of 1 mm RMS at the corners.
double ConstraintOf(const PlaneFit& fit, const Vector2d& size_px, double mm_per_residual) {
  PlaneMatrix corners = PlaneMatrix::Zero();
  for (const Vector2d& corner : CornersPx(size_px)) {
    const auto jacobian = fit.JacobianAt(corner);
    corners += jacobian.transpose() * jacobian / 4.0;
  }
  const auto count = static_cast<double>(std::ranges::count(fit.used, true));
  const PlaneMatrix normal = fit.normal * (mm_per_residual * mm_per_residual / count);
  const Eigen::GeneralizedSelfAdjointEigenSolver<PlaneMatrix> solver(normal, corners);
  const double constraint = std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
  if (constraint < kLeastConstraint) {
    throw NoAnswerError(
        Message("the points do not determine the calibration: they move by ", constraint,
                " mm where the image moves by 1 mm at its corners (at "
                "least ",
                kLeastConstraint, "); ", Remedy(solver.eigenvectors().col(0), fit.plane, size_px)));
  }
  return constraint;
}

double Rms(double squares, std::size_t count) {
  return count == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(count));
}

std::vector<PixelError> CornerErrors(const PlaneFit& fit, const Vector2d& size_px,
                                     double confidence) {
  std::vector<PixelError> errors;
  for (const Vector2d& corner : CornersPx(size_px)) {
    const auto jacobian = fit.JacobianAt(corner);
    const Matrix3d covariance = jacobian * fit.covariance * jacobian.transpose();
    const Matrix3d in_image = fit.plane.axes.transpose() * covariance * fit.plane.axes;
    errors.push_back(
        {corner, in_image.diagonal().cwiseMax(0.0).cwiseSqrt(),
         LengthBoundMm(covariance, confidence, static_cast<double>(fit.num_clusters - 1))});
  }
  return errors;
}

/// Plane and residuals, without what is special to wires or points, and without errors.
ProbeCalibration CalibrationOf(const PlaneFit& fit, const std::vector<PlanePoint>& points) {
  ProbeCalibration result;
  result.probe_from_image.linear() = fit.plane.axes;
  result.probe_from_image.translation() = fit.plane.origin_mm;
  result.mm_per_px = fit.plane.mm_per_px;
  result.num_images = fit.num_clusters;
  const Vector3d mm_per_px(fit.plane.mm_per_px.x(), fit.plane.mm_per_px.y(), 0.0);
  double squares = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d scale = points[i].is_wire ? mm_per_px : Vector3d(Vector3d::Ones());
    const Vector3d residual_mm = fit.residuals[i].cwiseProduct(scale);
    result.residuals.push_back({points[i].cluster, 0, residual_mm, fit.used[i]});
    if (fit.used[i]) squares += residual_mm.head<2>().squaredNorm();
  }
  result.in_plane_rms_mm =
      Rms(squares, static_cast<std::size_t>(std::ranges::count(fit.used, true)));
  return result;
}

void RequirePlausible(const ProbeCalibration& result, double limit_mm) {
  const auto used = std::ranges::count(result.residuals, true, &PointResidual::used);
  const double share = static_cast<double>(used) / static_cast<double>(result.residuals.size());
  const double rms_mm = std::hypot(result.in_plane_rms_mm, result.out_of_plane_rms_mm);
  if (!(rms_mm <= limit_mm) || share < kFewestUsed) {
    throw NoAnswerError(Message(
        "the points do not fit one calibration: ", rms_mm, " mm RMS (allowed: ", limit_mm,
        " mm, --limit-mm) over ", std::lround(100.0 * share), " % of ", result.residuals.size(),
        " points (at least 60 %); check the names of the wires, the phantom's pose, the times of "
        "the images and which of the recording's tools is the probe"));
  }
  ACUS_REQUIRE(result.mm_per_px.minCoeff() >= kFinestMmPerPx &&
                   result.mm_per_px.maxCoeff() <= kCoarsestMmPerPx,
               "a pixel would be ", result.mm_per_px.x(), " x ", result.mm_per_px.y(),
               " mm; images have ", kFinestMmPerPx, " to ", kCoarsestMmPerPx,
               " mm per pixel: are poses and points in mm, and the image's in pixels?");
}

/// Refuses what is no calibration, and adds how far a good one may be wrong.
void AddErrors(const PlaneFit& fit, bool is_wires, const Vector2d& size_px,
               const ProbeCalibrationSettings& settings, ProbeCalibration& result) {
  RequirePlausible(result, settings.limit_mm);
  result.constraint = ConstraintOf(fit, size_px, is_wires ? fit.plane.mm_per_px.mean() : 1.0);
  const double quantile = math::StudentQuantile(0.5 + 0.5 * settings.confidence,
                                                static_cast<double>(fit.num_clusters - 1));
  result.mm_per_px_half_width = quantile * fit.covariance.diagonal().tail<2>().cwiseSqrt();
  result.corners = CornerErrors(fit, size_px, settings.confidence);
}

/// The settings', or that of the points that are used.
Vector2d SizeOf(const std::vector<PlanePoint>& points, const std::vector<bool>& used,
                const ProbeCalibrationSettings& settings) {
  Vector2d size_px = settings.image_px;
  if (size_px.minCoeff() > 0.0) return size_px;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (used[i]) size_px = size_px.cwiseMax(points[i].point_px);
  }
  return size_px.cwiseMax(1.0);
}

/// The three pixels of a pattern, if all are seen.
std::optional<std::array<Vector2d, 3>> WholeN(const WireImage& image, std::size_t pattern) {
  std::array<Vector2d, 3> points;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto& point = image.points_px.at(3 * pattern + i);
    if (!point) return {};
    points[i] = *point;
  }
  if ((points[2] - points[0]).norm() < 1.0) return {};
  return points;
}

/// Between the ends of a wire, or a tenth of its length beyond them: a pixel far off the N, which
/// would have a large influence on the start, is not.
bool IsOnWire(const Wire& wire, const Vector3d& point_mm) {
  const Vector3d whole_mm = wire.back_mm - wire.front_mm;
  const double share = (point_mm - wire.front_mm).dot(whole_mm) / whole_mm.squaredNorm();
  return share > -0.1 && share < 1.1;
}

struct MiddleWires {
  std::vector<Vector2d> points_px;
  std::vector<Vector3d> places_mm;  ///< In the probe's frame.
  std::size_t num_images = 0;
};

MiddleWires MiddleWiresOf(const WirePhantom& phantom, std::span<const WireImage> images) {
  MiddleWires middle;
  for (const WireImage& image : images) {
    const std::size_t before = middle.points_px.size();
    for (std::size_t n = 0; n < phantom.patterns.size(); ++n) {
      const auto points = WholeN(image, n);
      if (!points) continue;
      const Vector3d place_mm = MiddleWirePoint(phantom.patterns[n], *points);
      if (!IsOnWire(phantom.patterns[n][1], place_mm)) continue;
      middle.points_px.push_back((*points)[1]);
      middle.places_mm.push_back(image.probe_from_phantom * place_mm);
    }
    if (middle.points_px.size() > before) ++middle.num_images;
  }
  return middle;
}

/// Errors of the middle wires whose N has no outlier, and their RMS out of the plane.
void AddMiddleWires(const WirePhantom& phantom, std::span<const WireImage> images,
                    ProbeCalibration& result) {
  std::set<std::pair<std::size_t, std::size_t>> outliers;
  for (const PointResidual& point : result.residuals) {
    if (!point.used) outliers.insert({point.image, point.wire / 3});
  }
  double squares = 0.0;
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (std::size_t n = 0; n < phantom.patterns.size(); ++n) {
      const auto points = WholeN(images[i], n);
      if (!points || outliers.contains({i, n})) continue;
      const Vector2d in_image_mm = result.mm_per_px.cwiseProduct((*points)[1]);
      const Vector3d place_mm =
          result.probe_from_image.inverse() *
          (images[i].probe_from_phantom * MiddleWirePoint(phantom.patterns[n], *points));
      const Vector3d error_mm = Vector3d(in_image_mm.x(), in_image_mm.y(), 0.0) - place_mm;
      result.middle_wires.push_back({i, n, error_mm});
      squares += error_mm.z() * error_mm.z();
    }
  }
  result.out_of_plane_rms_mm = Rms(squares, result.middle_wires.size());
}

}  // namespace

Eigen::Matrix4d ProbeCalibration::ImageToProbe() const {
  Eigen::Matrix4d matrix = probe_from_image.matrix();
  matrix.col(0) *= mm_per_px.x();
  matrix.col(1) *= mm_per_px.y();
  matrix.col(2) *= mm_per_px.mean();
  return matrix;
}

ProbeCalibration CalibrateByWires(const WirePhantom& phantom, std::span<const WireImage> images,
                                  const ProbeCalibrationSettings& settings) {
  const MiddleWires middle = MiddleWiresOf(phantom, images);
  if (middle.num_images < kLeastImages) {
    throw NoAnswerError(Message(middle.num_images,
                                " images show the three wires of an N; at least ", kLeastImages,
                                " are needed: add images of the phantom from other "
                                "places and angles"));
  }
  RequireSpread(middle.points_px,
                "add images in which the wires lie at other depths and sides, or mark several N");
  std::vector<PlanePoint> points;
  std::vector<std::size_t> wires;
  for (std::size_t i = 0; i < images.size(); ++i) {
    const Eigen::Isometry3d& pose = images[i].probe_from_phantom;
    for (std::size_t w = 0; w < phantom.num_wires(); ++w) {
      const auto& point_px = images[i].points_px.at(w);
      if (!point_px) continue;
      const Wire& wire = phantom.WireAt(w);
      points.push_back({i, *point_px, true, pose * wire.front_mm,
                        pose.linear() * (wire.back_mm - wire.front_mm).normalized()});
      wires.push_back(w);
    }
  }
  const PlaneFit fit = FitPlane(points, LinearPlane(middle.points_px, middle.places_mm));
  ProbeCalibration result = CalibrationOf(fit, points);
  for (std::size_t i = 0; i < wires.size(); ++i) result.residuals[i].wire = wires[i];
  AddMiddleWires(phantom, images, result);
  AddErrors(fit, true, SizeOf(points, fit.used, settings), settings, result);
  return result;
}

ProbeCalibration CalibrateByPoints(std::span<const SeenPoint> points,
                                   const ProbeCalibrationSettings& settings) {
  if (points.size() < kLeastImages) {
    throw NoAnswerError(Message("there are ", points.size(), " points of the stylus; at least ",
                                kLeastImages, " are needed, spread over the whole image"));
  }
  std::vector<PlanePoint> plane_points;
  std::vector<Vector2d> points_px;
  std::vector<Vector3d> places_mm;
  for (std::size_t i = 0; i < points.size(); ++i) {
    plane_points.push_back({i, points[i].point_px, false, points[i].probe_mm});
    points_px.push_back(points[i].point_px);
    places_mm.push_back(points[i].probe_mm);
  }
  RequireSpread(points_px, "add points at other depths and sides of the image");
  const PlaneFit fit = FitPlane(plane_points, LinearPlane(points_px, places_mm));
  ProbeCalibration result = CalibrationOf(fit, plane_points);
  double squares = 0.0;
  for (const PointResidual& point : result.residuals) {
    if (point.used) squares += point.residual_mm.z() * point.residual_mm.z();
  }
  result.out_of_plane_rms_mm = Rms(squares, static_cast<std::size_t>(std::ranges::count(
                                                result.residuals, true, &PointResidual::used)));
  AddErrors(fit, false, SizeOf(plane_points, fit.used, settings), settings, result);
  return result;
}

}  // namespace acus::registration
