#include "acus/imaging/fluoroscopy/c_arm.h"

#include <cmath>
#include <limits>

#include "acus/base/config/json_file.h"
#include "acus/base/core/error.h"

namespace acus::fluoroscopy {
namespace {

constexpr int kMaxPx = 4096;

void Check(const CArm& c_arm, const CArmPose& pose) {
  ACUS_REQUIRE(c_arm.source_detector_mm > 0.0 && c_arm.source_isocentre_mm > 0.0 &&
                   c_arm.source_isocentre_mm < c_arm.source_detector_mm &&
                   std::isfinite(c_arm.source_detector_mm),
               "C-arm: source to isocentre is ", c_arm.source_isocentre_mm, " mm, to the detector ",
               c_arm.source_detector_mm, " mm; the isocentre must lie between the two");
  ACUS_REQUIRE(c_arm.width_px >= 16 && c_arm.height_px >= 16 && c_arm.width_px <= kMaxPx &&
                   c_arm.height_px <= kMaxPx,
               "C-arm: detector of ", c_arm.width_px, " x ", c_arm.height_px,
               " pixels; allowed is 16 to ", kMaxPx, " each way");
  ACUS_REQUIRE(c_arm.detector_width_mm > 0.0 && c_arm.detector_height_mm > 0.0 &&
                   std::isfinite(c_arm.detector_width_mm + c_arm.detector_height_mm),
               "C-arm: detector of ", c_arm.detector_width_mm, " x ", c_arm.detector_height_mm,
               " mm; both must be above 0");
  ACUS_REQUIRE(c_arm.water_per_mm > 0.0 && c_arm.metal_per_mm >= 0.0 &&
                   std::isfinite(c_arm.water_per_mm + c_arm.metal_per_mm),
               "C-arm: attenuation of water ", c_arm.water_per_mm, " and of metal ",
               c_arm.metal_per_mm, " per mm; water must be above 0, metal not below");
  ACUS_REQUIRE(c_arm.detail == 1 || c_arm.detail == 2 || c_arm.detail == 4, "C-arm: detail is ",
               c_arm.detail, "; allowed: 1, 2, 4");
  const bool automatic = c_arm.window_low == 0.0 && c_arm.window_high == 0.0;
  ACUS_REQUIRE(automatic || c_arm.window_high > c_arm.window_low, "C-arm: the window is from ",
               c_arm.window_low, " to ", c_arm.window_high,
               "; the upper end must be above the lower, or both 0 for one from the patient");
  ACUS_REQUIRE(pose.isocentre_in_ct_mm.allFinite() && std::isfinite(pose.lao_rad) &&
                   std::isfinite(pose.cranial_rad),
               "C-arm: its pose is not finite");
}

}  // namespace

CArm ReadCArm(const std::filesystem::path& path) {
  const auto json = config::ReadConfig(path, "acus-c-arm");
  CArm c_arm;
  c_arm.name = json.at("name");
  c_arm.source_detector_mm = json.at("source_detector_mm");
  c_arm.source_isocentre_mm = json.at("source_isocentre_mm");
  c_arm.detector_width_mm = json.at("detector_width_mm");
  c_arm.detector_height_mm = json.at("detector_height_mm");
  c_arm.width_px = json.at("width_px");
  c_arm.height_px = json.at("height_px");
  c_arm.water_per_mm = json.at("water_per_mm");
  c_arm.metal_per_mm = json.at("metal_per_mm");
  c_arm.detail = json.at("detail");
  c_arm.scale = json.at("scale") == "log" ? FluoroscopyScale::kLog : FluoroscopyScale::kLinear;
  c_arm.dark_bone = json.at("bone") == "dark";
  c_arm.window_low = json.at("window")[0];
  c_arm.window_high = json.at("window")[1];
  try {
    CArmGeometry(c_arm, {});
  } catch (const InputError& error) {
    throw InputError(Message(path.string(), ": ", error.what()));
  }
  return c_arm;
}

CArmGeometry::CArmGeometry(const CArm& c_arm, const CArmPose& pose)
    : source_detector_mm_(c_arm.source_detector_mm) {
  Check(c_arm, pose);
  const double cos_a = std::cos(pose.lao_rad);
  const double sin_a = std::sin(pose.lao_rad);
  const double cos_b = std::cos(pose.cranial_rad);
  const double sin_b = std::sin(pose.cranial_rad);
  direction_ = {sin_a * cos_b, -cos_a * cos_b, sin_b};
  const Eigen::Vector3d right(cos_a, sin_a, 0.0);
  const Eigen::Vector3d down = -direction_.cross(right);
  source_mm_ = pose.isocentre_in_ct_mm - c_arm.source_isocentre_mm * direction_;
  column_step_mm_ = c_arm.detector_width_mm / c_arm.width_px * right;
  row_step_mm_ = c_arm.detector_height_mm / c_arm.height_px * down;
  first_pixel_mm_ = source_mm_ + c_arm.source_detector_mm * direction_ -
                    0.5 * (c_arm.width_px - 1) * column_step_mm_ -
                    0.5 * (c_arm.height_px - 1) * row_step_mm_;
}

Eigen::Vector2d CArmGeometry::Project(const Eigen::Vector3d& in_ct_mm) const {
  const Eigen::Vector3d from_source = in_ct_mm - source_mm_;
  const double along_mm = from_source.dot(direction_);
  if (!(along_mm > 0.0)) {
    return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  }
  const Eigen::Vector3d hit_mm =
      source_mm_ + source_detector_mm_ / along_mm * from_source - first_pixel_mm_;
  return {hit_mm.dot(column_step_mm_) / column_step_mm_.squaredNorm(),
          hit_mm.dot(row_step_mm_) / row_step_mm_.squaredNorm()};
}

Eigen::Affine3d CArmGeometry::ct_from_image() const {
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  out.linear().col(0) = column_step_mm_;
  out.linear().col(1) = row_step_mm_;
  out.linear().col(2) = -mm_per_px() * direction_;
  out.translation() = first_pixel_mm_;
  return out;
}

}  // namespace acus::fluoroscopy
