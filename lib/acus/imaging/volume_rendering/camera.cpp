#include "acus/imaging/volume_rendering/camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "acus/base/core/error.h"

namespace acus::volume_rendering {
namespace {

constexpr int kLargestPx = 8192;

struct Side {
  std::string_view name;
  Eigen::Vector3d from;  ///< From the focus to the eye, LPS.
  Eigen::Vector3d up;
};

const std::array<Side, 7>& Sides() {
  static const std::array<Side, 7> sides = {{
      {"anterior", {0, -1, 0}, {0, 0, 1}},
      {"posterior", {0, 1, 0}, {0, 0, 1}},
      {"left", {1, 0, 0}, {0, 0, 1}},
      {"right", {-1, 0, 0}, {0, 0, 1}},
      {"superior", {0, 0, 1}, {0, -1, 0}},
      {"inferior", {0, 0, -1}, {0, -1, 0}},
      {"oblique", {-0.55, -0.75, 0.37}, {0, 0, 1}},
  }};
  return sides;
}

}  // namespace

Eigen::Vector2d Camera::ProjectPx(const Eigen::Vector3d& point_in_ct_mm) const {
  const Eigen::Vector3d at = camera_from_ct * point_in_ct_mm;
  return focal_px.cwiseProduct(at.head<2>() / at[2]) + centre_px;
}

Eigen::Vector3d Camera::DirectionInCt(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d slope = (pixel - centre_px).cwiseQuotient(focal_px);
  return camera_from_ct.linear().transpose() * Eigen::Vector3d(slope[0], slope[1], 1.0);
}

Camera Camera::Magnified(int factor) const {
  Camera out = *this;
  out.width_px *= factor;
  out.height_px *= factor;
  out.focal_px *= factor;
  // Pixel c becomes the pixels factor * c ... factor * c + factor - 1.
  out.centre_px = factor * centre_px + Eigen::Vector2d::Constant(0.5 * (factor - 1));
  return out;
}

void Camera::Check() const {
  ACUS_REQUIRE(width_px >= 1 && height_px >= 1 && width_px <= kLargestPx && height_px <= kLargestPx,
               "camera: an image of ", width_px, " x ", height_px, " pixels; allowed is 1 to ",
               kLargestPx, " each way");
  ACUS_REQUIRE(focal_px.allFinite() && centre_px.allFinite() && (focal_px.array() > 0.0).all() &&
                   camera_from_ct.matrix().allFinite(),
               "camera: focal lengths must be positive, and all numbers finite");
}

Camera LookAt(const Viewpoint& viewpoint, const ImageSize& size) {
  const Eigen::Vector3d forward = viewpoint.focus_in_ct_mm - viewpoint.eye_in_ct_mm;
  ACUS_REQUIRE(forward.allFinite() && forward.norm() > 1e-6,
               "camera: eye and focus are at the same place");
  ACUS_REQUIRE(viewpoint.view_angle_deg > 0.0 && viewpoint.view_angle_deg < 150.0,
               "camera: a view angle of ", viewpoint.view_angle_deg,
               " degrees; allowed is above 0 and below 150");
  const Eigen::Vector3d z = forward.normalized();
  const Eigen::Vector3d across = z.cross(viewpoint.up_in_ct);
  ACUS_REQUIRE(
      across.allFinite() && across.norm() > 1e-6 * viewpoint.up_in_ct.norm() && across.norm() > 0.0,
      "camera: `up` runs along the line of sight; choose another one");
  Eigen::Matrix3d ct_from_camera;
  ct_from_camera.col(0) = across.normalized();
  ct_from_camera.col(1) = z.cross(across.normalized());
  ct_from_camera.col(2) = z;
  Camera camera;
  camera.camera_from_ct.linear() = ct_from_camera.transpose();
  camera.camera_from_ct.translation() = -(ct_from_camera.transpose() * viewpoint.eye_in_ct_mm);
  camera.width_px = size.width_px;
  camera.height_px = size.height_px;
  const double half_angle = viewpoint.view_angle_deg * std::numbers::pi / 360.0;
  camera.focal_px.setConstant(0.5 * size.height_px / std::tan(half_angle));
  camera.centre_px = {0.5 * (size.width_px - 1), 0.5 * (size.height_px - 1)};
  camera.Check();
  return camera;
}

Viewpoint ViewFrom(std::string_view side, const Eigen::AlignedBox3d& box_in_ct_mm,
                   const ImageSize& size, double view_angle_deg) {
  const auto& sides = Sides();
  const auto* found = std::ranges::find(sides, side, &Side::name);
  if (found == sides.end()) {
    std::string names;
    for (const Side& known : sides) names += (names.empty() ? "" : ", ") + std::string(known.name);
    throw InputError(Message("camera: there is no view from \"", side, "\"; allowed are ", names));
  }
  ACUS_REQUIRE(!box_in_ct_mm.isEmpty() && box_in_ct_mm.diagonal().norm() > 0.0,
               "camera: there is nothing to look at");
  Viewpoint out;
  out.view_angle_deg = view_angle_deg;
  out.focus_in_ct_mm = box_in_ct_mm.center();
  out.up_in_ct = found->up;
  const Eigen::Vector3d back = found->from.normalized();
  const Eigen::Vector3d right = found->up.cross(back).normalized();
  const Eigen::Vector3d up = back.cross(right);
  const double tangent = std::tan(out.view_angle_deg * std::numbers::pi / 360.0);
  const double aspect = static_cast<double>(size.width_px) / std::max(1, size.height_px);
  // As far away as the corner that needs it most, and a little air around.
  double distance_mm = 1.0;
  for (int n = 0; n < 8; ++n) {
    const Eigen::Vector3d corner =
        box_in_ct_mm.corner(static_cast<Eigen::AlignedBox3d::CornerType>(n)) - out.focus_in_ct_mm;
    const double half_mm = std::max(std::abs(corner.dot(up)), std::abs(corner.dot(right)) / aspect);
    distance_mm = std::max(distance_mm, corner.dot(back) + 1.04 * half_mm / tangent);
  }
  out.eye_in_ct_mm = out.focus_in_ct_mm + distance_mm * back;
  return out;
}

}  // namespace acus::volume_rendering
