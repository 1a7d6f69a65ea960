// Poses of planes through a point of the patient.
#pragma once

#include <Eigen/Geometry>
#include <string_view>

namespace acus::effects {

enum class PatientPlane {
  kAxial,     ///< Seen from the feet: the patient's left on the right, his front above.
  kCoronal,   ///< Seen from the front: his left on the right, his head above.
  kSagittal,  ///< Seen from his right: his back on the right, his head above.
  kOblique,   ///< Along the needle, which points downwards, as nearly axial as it can be.
};

/// "axial", "coronal", "sagittal", "oblique".
/// @throws InputError for another name.
PatientPlane PatientPlaneOf(std::string_view name);
std::string_view TitleOf(PatientPlane plane) noexcept;

/// Columns run along x, rows along y, in CT space (left, posterior, superior).
/// @param needle_axis  Unit, from the hub to the tip; zero: an oblique plane is the axial one.
Eigen::Isometry3d PoseOf(PatientPlane plane, const Eigen::Vector3d& through_in_ct_mm,
                         const Eigen::Vector3d& needle_axis);

}  // namespace acus::effects
