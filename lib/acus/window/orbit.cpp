#include "acus/window/orbit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace acus::window {
namespace {

constexpr std::array<std::string_view, 7> kSides = {"anterior", "posterior", "left",   "right",
                                                    "superior", "inferior",  "oblique"};
constexpr double kRadPerPx = 0.008;
constexpr int kObliquePreset = 7;
constexpr double kNarrow = 1.6;  // The ratio of width to height for which presets are designed.

}  // namespace

Orbit::Orbit(const Eigen::AlignedBox3d& box_in_ct_mm) : box_(box_in_ct_mm) {
  if (box_.isEmpty())
    box_.extend(Eigen::Vector3d::Constant(-100.0)).extend(Eigen::Vector3d::Constant(100.0));
  SetPreset(kObliquePreset);
}

void Orbit::SetPreset(int number) {
  if (number < 1 || number > static_cast<int>(kSides.size())) return;
  // A wide image: the box fits into its height.
  constexpr volume_rendering::ImageSize kSize{.width_px = 640, .height_px = 400};
  viewpoint_ =
      volume_rendering::ViewFrom(kSides[static_cast<std::size_t>(number - 1)], box_, kSize);
}

void Orbit::LookAtSideOf(const Eigen::Vector3d& place_in_ct_mm) {
  // The patient is long: only the direction around the axis, z, is used.
  Eigen::Vector3d side = place_in_ct_mm - box_.center();
  side.z() = 0.0;
  if (!side.allFinite() || side.norm() < 1.0) return;
  side.normalize();
  const Eigen::Vector3d aslant = Eigen::Vector3d::UnitZ().cross(side);
  SetPreset(kObliquePreset);
  const double distance = distance_mm();
  const Eigen::Vector3d towards =
      (side + 0.5 * aslant + 0.5 * Eigen::Vector3d::UnitZ()).normalized();
  viewpoint_.eye_in_ct_mm = viewpoint_.focus_in_ct_mm + distance * towards;
  viewpoint_.up_in_ct = Eigen::Vector3d::UnitZ();
}

void Orbit::Turn(double right_px, double down_px) {
  Eigen::Vector3d back = viewpoint_.eye_in_ct_mm - viewpoint_.focus_in_ct_mm;
  const Eigen::Vector3d right = viewpoint_.up_in_ct.cross(back).normalized();
  const Eigen::Vector3d up = back.cross(right).normalized();
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(-kRadPerPx * right_px, up) *
                                Eigen::AngleAxisd(-kRadPerPx * down_px, right))
                                   .toRotationMatrix();
  back = turn * back;
  viewpoint_.eye_in_ct_mm = viewpoint_.focus_in_ct_mm + back;
  viewpoint_.up_in_ct = (turn * up).normalized();
}

void Orbit::Shift(double right_px, double down_px, int height_px) {
  const Eigen::Vector3d back = viewpoint_.eye_in_ct_mm - viewpoint_.focus_in_ct_mm;
  const Eigen::Vector3d right = viewpoint_.up_in_ct.cross(back).normalized();
  const Eigen::Vector3d up = back.cross(right).normalized();
  const double half_angle = 0.5 * viewpoint_.view_angle_deg * std::numbers::pi / 180.0;
  const double mm_per_px = 2.0 * back.norm() * std::tan(half_angle) / std::max(1, height_px);
  const Eigen::Vector3d by = mm_per_px * (down_px * up - right_px * right);
  viewpoint_.eye_in_ct_mm += by;
  viewpoint_.focus_in_ct_mm += by;
}

void Orbit::Zoom(double factor) {
  const Eigen::Vector3d back = viewpoint_.eye_in_ct_mm - viewpoint_.focus_in_ct_mm;
  const double size = patient_size_mm();
  const double distance = std::clamp(factor * back.norm(), 0.15 * size, 8.0 * size);
  viewpoint_.eye_in_ct_mm = viewpoint_.focus_in_ct_mm + distance * back.normalized();
}

volume_rendering::Camera Orbit::CameraFor(int width_px, int height_px) const {
  volume_rendering::Camera camera =
      volume_rendering::LookAt(viewpoint_, {.width_px = width_px, .height_px = height_px});
  // The angle is over the height; a narrow image needs a larger one.
  camera.focal_px *= std::min(1.0, width_px / (kNarrow * height_px));
  return camera;
}

volume_rendering::Camera Orbit::EyeFor(int width_px, int height_px, double half_base_mm) const {
  volume_rendering::Camera camera = CameraFor(width_px, height_px);
  camera.camera_from_ct = Eigen::Translation3d(-half_base_mm, 0.0, 0.0) * camera.camera_from_ct;
  camera.centre_px[0] += camera.focal_px[0] * half_base_mm / distance_mm();
  return camera;
}

Eigen::Vector3d Orbit::TowardsEye() const {
  return (viewpoint_.eye_in_ct_mm - viewpoint_.focus_in_ct_mm).normalized();
}

double Orbit::distance_mm() const {
  return (viewpoint_.eye_in_ct_mm - viewpoint_.focus_in_ct_mm).norm();
}

}  // namespace acus::window
