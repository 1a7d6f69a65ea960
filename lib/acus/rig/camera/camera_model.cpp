#include "acus/rig/camera/camera_model.h"

#include <cmath>
#include <numbers>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"
#include "acus/rig/camera/opencv_model.h"

namespace acus::camera {
namespace {

using nlohmann::json;

constexpr double kNearestMm = 1.0;
constexpr double kLargestRadius = 20.0;  ///< 87 degrees to the side.

/// d(s r)/dr: where it is not above 0, the lens folds.
double RadialSlope(const std::array<double, 3>& k, double radius) {
  const double u = radius * radius;
  return 1.0 + u * (3.0 * k[0] + u * (5.0 * k[1] + u * 7.0 * k[2]));
}

/// Within which the radial part grows: the first fold, by steps and bisection.
double RadiusOfFold(const std::array<double, 3>& k) {
  constexpr double kStep = 0.01;
  double inside = 0.0;
  while (inside < kLargestRadius && RadialSlope(k, inside + kStep) > 0.0) inside += kStep;
  if (inside >= kLargestRadius) return kLargestRadius;
  double outside = inside + kStep;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (inside + outside);
    (RadialSlope(k, middle) > 0.0 ? inside : outside) = middle;
  }
  return inside;
}

void CheckNumbers(const CameraParameters& p) {
  ACUS_REQUIRE(p.width_px >= 16 && p.height_px >= 16 && p.width_px <= 8192 && p.height_px <= 8192,
               "camera '", p.name, "': an image of ", p.width_px, " x ", p.height_px,
               " pixels; allowed is 16 to 8192 each way");
  ACUS_REQUIRE(p.focal_px.allFinite() && p.focal_px.minCoeff() > 0.0, "camera '", p.name,
               "': focal lengths ", p.focal_px[0], ", ", p.focal_px[1],
               " px; they must be above 0");
  ACUS_REQUIRE(p.centre_px.allFinite() && p.centre_px.minCoeff() >= 0.0 &&
                   p.centre_px[0] < p.width_px && p.centre_px[1] < p.height_px,
               "camera '", p.name, "': centre ", p.centre_px[0], ", ", p.centre_px[1],
               " px; it must be in the image of ", p.width_px, " x ", p.height_px);
  for (const double value :
       {p.radial[0], p.radial[1], p.radial[2], p.tangential[0], p.tangential[1]}) {
    ACUS_REQUIRE(std::isfinite(value), "camera '", p.name, "': a distortion that is not finite");
  }
}

}  // namespace

CameraModel::CameraModel(CameraParameters parameters) : parameters_(std::move(parameters)) {
  CheckNumbers(parameters_);
  for (const double value : parameters_.radial) has_distortion_ |= value != 0.0;
  for (const double value : parameters_.tangential) has_distortion_ |= value != 0.0;
  largest_radius_ = RadiusOfFold(parameters_.radial);
  constexpr int kSteps = 32;
  for (int i = 0; i <= kSteps; ++i) {
    const double across = -0.5 + i * static_cast<double>(parameters_.width_px) / kSteps;
    const double down = -0.5 + i * static_cast<double>(parameters_.height_px) / kSteps;
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(across, -0.5), Eigen::Vector2d(across, parameters_.height_px - 0.5),
          Eigen::Vector2d(-0.5, down), Eigen::Vector2d(parameters_.width_px - 0.5, down)}) {
      ACUS_REQUIRE(Ray(pixel).has_value(), "camera '", parameters_.name,
                   "': its distortion folds the image: nothing is seen at pixel ", pixel[0], ", ",
                   pixel[1],
                   "; check radial and tangential, or calibrate again with views of the "
                   "image's corners");
    }
  }
}

Eigen::Vector2d CameraModel::Distort(const Eigen::Vector2d& slope,
                                     Eigen::Matrix2d* derivative) const noexcept {
  const auto& [k1, k2, k3] = parameters_.radial;
  const auto& [p1, p2] = parameters_.tangential;
  const double x = slope[0];
  const double y = slope[1];
  const double u = x * x + y * y;
  const double s = 1.0 + u * (k1 + u * (k2 + u * k3));
  if (derivative != nullptr) {
    const double s_u = k1 + u * (2.0 * k2 + 3.0 * u * k3);
    const double mixed = 2.0 * x * y * s_u + 2.0 * p1 * x + 2.0 * p2 * y;
    *derivative << s + 2.0 * x * x * s_u + 2.0 * p1 * y + 6.0 * p2 * x, mixed, mixed,
        s + 2.0 * y * y * s_u + 6.0 * p1 * y + 2.0 * p2 * x;
  }
  return {s * x + 2.0 * p1 * x * y + p2 * (u + 2.0 * x * x),
          s * y + p1 * (u + 2.0 * y * y) + 2.0 * p2 * x * y};
}

std::optional<Eigen::Vector2d> CameraModel::Project(
    const Eigen::Vector3d& point_in_camera_mm) const noexcept {
  Eigen::Matrix<double, 2, 3> ignored;
  return Project(point_in_camera_mm, ignored);
}

std::optional<Eigen::Vector2d> CameraModel::Project(
    const Eigen::Vector3d& point_in_camera_mm,
    Eigen::Matrix<double, 2, 3>& derivative) const noexcept {
  const double z = point_in_camera_mm[2];
  if (!(z >= kNearestMm) || !point_in_camera_mm.allFinite()) return std::nullopt;
  const Eigen::Vector2d slope = point_in_camera_mm.head<2>() / z;
  if (slope.norm() > largest_radius_) return std::nullopt;
  Eigen::Matrix2d lens;
  const Eigen::Vector2d distorted = Distort(slope, &lens);
  Eigen::Matrix<double, 2, 3> slope_by_point;
  slope_by_point << 1.0 / z, 0.0, -slope[0] / z, 0.0, 1.0 / z, -slope[1] / z;
  derivative = parameters_.focal_px.asDiagonal() * lens * slope_by_point;
  return parameters_.focal_px.cwiseProduct(distorted) + parameters_.centre_px;
}

std::optional<Eigen::Vector3d> CameraModel::Ray(const Eigen::Vector2d& pixel) const noexcept {
  if (!pixel.allFinite()) return std::nullopt;
  const Eigen::Vector2d wanted =
      (pixel - parameters_.centre_px).cwiseQuotient(parameters_.focal_px);
  if (!has_distortion_) {
    if (wanted.norm() > largest_radius_) return std::nullopt;
    return Eigen::Vector3d(wanted[0], wanted[1], 1.0);
  }
  // Newton, with steps held within the fold: from the middle outwards the radius grows with s r.
  const double tolerance = 1e-10 / parameters_.focal_px.maxCoeff();
  Eigen::Vector2d slope = wanted * std::min(1.0, largest_radius_ / std::max(1e-12, wanted.norm()));
  for (int i = 0; i < 60; ++i) {
    Eigen::Matrix2d lens;
    const Eigen::Vector2d residual = Distort(slope, &lens) - wanted;
    if (residual.norm() <= tolerance) return Eigen::Vector3d(slope[0], slope[1], 1.0);
    const double determinant = lens.determinant();
    if (!(determinant > 1e-9)) {
      slope *= 0.9;  // At the fold: step back inside.
      continue;
    }
    slope -= lens.inverse() * residual;
    const double radius = slope.norm();
    if (!(radius <= largest_radius_)) slope *= 0.999 * largest_radius_ / radius;
    if (!slope.allFinite()) return std::nullopt;
  }
  // Rounding may keep it just above the tolerance.
  if ((Distort(slope, nullptr) - wanted).norm() <= 10.0 * tolerance) {
    return Eigen::Vector3d(slope[0], slope[1], 1.0);
  }
  return std::nullopt;
}

bool CameraModel::Contains(const Eigen::Vector2d& pixel, double margin_px) const noexcept {
  return pixel[0] >= margin_px && pixel[1] >= margin_px &&
         pixel[0] <= parameters_.width_px - 1 - margin_px &&
         pixel[1] <= parameters_.height_px - 1 - margin_px;
}

CameraModel CameraModel::Pinhole() const {
  CameraParameters straight = parameters_;
  straight.radial = {};
  straight.tangential = {};
  return CameraModel(straight);
}

double CameraModel::HorizontalAngleDeg() const {
  const double left = (parameters_.centre_px[0] + 0.5) / parameters_.focal_px[0];
  const double right =
      (parameters_.width_px - 0.5 - parameters_.centre_px[0]) / parameters_.focal_px[0];
  return (std::atan(left) + std::atan(right)) * 180.0 / std::numbers::pi;
}

CameraModel ReadCamera(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  if (ending == ".yml" || ending == ".yaml" || ending == ".xml") return ReadOpenCvCamera(path);
  return CameraOf(config::ReadConfig(path, "acus-camera"), path.string());
}

CameraModel CameraOf(const json& node, const std::string& where) {
  const json document = config::CheckedConfig(node, "acus-camera", where);
  CameraParameters p;
  p.name = document.at("name");
  p.description = document.at("description");
  p.width_px = document.at("width_px");
  p.height_px = document.at("height_px");
  for (int i = 0; i < 2; ++i) {
    p.focal_px[i] = document.at("focal_px")[static_cast<std::size_t>(i)];
    p.centre_px[i] = document.at("centre_px")[static_cast<std::size_t>(i)];
  }
  p.radial = document.at("radial").get<std::array<double, 3>>();
  p.tangential = document.at("tangential").get<std::array<double, 2>>();
  if (document.contains("reprojection_rms_px")) {
    p.reprojection_rms_px = document.at("reprojection_rms_px").get<double>();
  }
  try {
    return CameraModel(p);
  } catch (const InputError& error) {
    throw InputError(where + ": " + error.what());
  }
}

json ToJson(const CameraModel& camera) {
  const CameraParameters& p = camera.parameters();
  json out = {{"format", "acus-camera/1"},
              {"name", p.name},
              {"description", p.description},
              {"width_px", p.width_px},
              {"height_px", p.height_px},
              {"focal_px", {p.focal_px[0], p.focal_px[1]}},
              {"centre_px", {p.centre_px[0], p.centre_px[1]}},
              {"radial", p.radial},
              {"tangential", p.tangential}};
  if (p.reprojection_rms_px) out["reprojection_rms_px"] = *p.reprojection_rms_px;
  return out;
}

void WriteCamera(const std::filesystem::path& path, const CameraModel& camera) {
  config::WriteJson(path, ToJson(camera));
}

}  // namespace acus::camera
