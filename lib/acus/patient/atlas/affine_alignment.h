// Where a patient lies in the CT of another, as far as shifts, scales, shears and turns can say.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "acus/patient/breathing_registration/level_image.h"
#include "acus/patient/segmentation/voxels/mask.h"

namespace acus::atlas {

/// Starts with bodies at the same height and at many others, and refines the best of them by
/// Gauss-Newton steps on robust squared differences (Geman & McClure). Both patients must lie the
/// same way round, which CT space (LPS) sees to.
/// @param image, body  Of the patient, on one grid; values as PatientImage gives them.
/// @return atlas_from_patient in CT space, mm; none if the two share too little of the body.
std::optional<Eigen::Affine3d> AlignBodies(const volume::Grid<float>& image,
                                           const segmentation::Mask& body,
                                           const breathing_registration::ModelImage& atlas,
                                           const segmentation::Mask& atlas_body);

}  // namespace acus::atlas
