// A C-arm: X-ray source and flat detector on opposite ends of an arc around the isocentre.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <string>

namespace acus::fluoroscopy {

/// What a fluoroscope shows.
enum class FluoroscopyScale {
  kLog,     ///< Grey is linear in the sum of attenuation: bone and soft tissue both keep contrast.
  kLinear,  ///< Grey is linear in what reaches the detector.
};

/// As in configs/schema/acus-c-arm.schema.json, where the ranges and defaults are.
struct CArm {
  std::string name;
  double source_detector_mm = 1000.0;
  double source_isocentre_mm = 600.0;
  double detector_width_mm = 300.0;
  double detector_height_mm = 300.0;
  int width_px = 512;
  int height_px = 512;
  double water_per_mm = 0.0206;  ///< Attenuation of water at the effective energy.
  double metal_per_mm = 0.95;    ///< Of the needle.
  int detail = 2;                ///< 1: every voxel; 2, 4: means of voxels that many times as long.
  FluoroscopyScale scale = FluoroscopyScale::kLog;
  bool dark_bone = true;  ///< As on C-arms; false: as on radiographs.
  /// Sums of attenuation that are shown brightest and darkest (with dark bone). Both 0: chosen from
  /// the patient without needle, once.
  double window_low = 0.0;
  double window_high = 0.0;
};

/// Where it stands. At 0, 0 the detector is in front of a patient on his back (-y in LPS).
struct CArmPose {
  Eigen::Vector3d isocentre_in_ct_mm = Eigen::Vector3d::Zero();
  double lao_rad = 0.0;      ///< Detector towards the patient's left; negative: right (RAO).
  double cranial_rad = 0.0;  ///< Detector towards the head; negative: caudal.
};

/// Reads configs/c_arms/<name>.json (format acus-c-arm/1). @throws InputError listing all problems.
CArm ReadCArm(const std::filesystem::path& path);

/// Straight lines from the source to the pixels. Pixel (c, r): column 0 is on the left of who looks
/// at the patient from the detector: at 0, 0 the patient's right; row 0 is towards the head.
class CArmGeometry {
 public:
  /// @throws InputError naming the first value that is out of range.
  CArmGeometry(const CArm& c_arm, const CArmPose& pose);

  const Eigen::Vector3d& source_in_ct_mm() const { return source_mm_; }
  /// Unit, from the source to the middle of the detector.
  const Eigen::Vector3d& direction_in_ct() const { return direction_; }
  Eigen::Vector3d PixelInCtMm(double column, double row) const {
    return first_pixel_mm_ + column * column_step_mm_ + row * row_step_mm_;
  }
  /// Column and row (continuous) where a point throws its shadow; not finite if it lies behind the
  /// source.
  Eigen::Vector2d Project(const Eigen::Vector3d& in_ct_mm) const;
  /// x_ct_mm = ct_from_image * (column, row, 0): the plane of the detector.
  Eigen::Affine3d ct_from_image() const;
  double mm_per_px() const { return column_step_mm_.norm(); }
  double mm_per_px_down() const { return row_step_mm_.norm(); }
  double source_detector_mm() const { return source_detector_mm_; }

 private:
  double source_detector_mm_;
  Eigen::Vector3d source_mm_;
  Eigen::Vector3d direction_;
  Eigen::Vector3d first_pixel_mm_;
  Eigen::Vector3d column_step_mm_;
  Eigen::Vector3d row_step_mm_;
};

}  // namespace acus::fluoroscopy
