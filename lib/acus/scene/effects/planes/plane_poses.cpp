#include "acus/scene/effects/planes/plane_poses.h"

#include "acus/base/core/error.h"

namespace acus::effects {

PatientPlane PatientPlaneOf(std::string_view name) {
  if (name == "axial") return PatientPlane::kAxial;
  if (name == "coronal") return PatientPlane::kCoronal;
  if (name == "sagittal") return PatientPlane::kSagittal;
  ACUS_REQUIRE(name == "oblique", "planes: \"", name,
               "\" is none; allowed are axial, coronal, sagittal and oblique");
  return PatientPlane::kOblique;
}

std::string_view TitleOf(PatientPlane plane) noexcept {
  switch (plane) {
    case PatientPlane::kAxial:
      return "axial";
    case PatientPlane::kCoronal:
      return "coronal";
    case PatientPlane::kSagittal:
      return "sagittal";
    case PatientPlane::kOblique:
      return "along the needle";
  }
  return "";
}

Eigen::Isometry3d PoseOf(PatientPlane plane, const Eigen::Vector3d& through_in_ct_mm,
                         const Eigen::Vector3d& needle_axis) {
  Eigen::Vector3d right = Eigen::Vector3d::UnitX();
  Eigen::Vector3d down = Eigen::Vector3d::UnitY();
  if (plane == PatientPlane::kCoronal) down = -Eigen::Vector3d::UnitZ();
  if (plane == PatientPlane::kSagittal) {
    right = Eigen::Vector3d::UnitY();
    down = -Eigen::Vector3d::UnitZ();
  }
  if (plane == PatientPlane::kOblique && needle_axis.norm() > 0.5) {
    down = needle_axis.normalized();
    // The direction in the axial plane perpendicular to the needle; for a needle along the patient,
    // the patient's left.
    Eigen::Vector3d across = down.cross(Eigen::Vector3d::UnitZ());
    if (across.norm() < 1e-3) across = Eigen::Vector3d::UnitX() - down[0] * down;
    right = across.normalized();
  }
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear().col(0) = right;
  pose.linear().col(1) = down;
  pose.linear().col(2) = right.cross(down);
  pose.translation() = through_in_ct_mm;
  return pose;
}

}  // namespace acus::effects
