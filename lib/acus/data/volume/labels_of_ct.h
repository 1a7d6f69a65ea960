// Whether a label map is that of a CT: bone and gas have Hounsfield units that nothing else has.
#pragma once

#include <optional>
#include <string>

#include "acus/data/volume/volume.h"

namespace acus::volume {

/// Why the labels cannot be those of the CT: the share of a tissue's voxels that have its HU in the
/// CT is below kLeastShare. Nothing if they fit, or have too little bone, lung and gas to judge by.
/// The grids may differ.
///
/// Bone: 60 HU or more; lung and gas: -200 HU or less. Measured: of a patient's own labels 0.85 to
/// 1.00 of the bone and 0.99 of the lung, in a real CT on 3 mm and in synthetic patients; of other
/// patients' or shifted labels 0.00 to 0.50. Patients who differ by a few mm are not found out.
std::optional<std::string> WhyLabelsAreOfAnother(const CtVolume& ct, const LabelMap& labels);

/// Why the labels may be of another scan or patient, or may be drawn roughly: the share of the
/// edges of bone across which the HU fall outwards is below kLeastEdgeShare. Nothing if there is no
/// doubt, or too little bone.
///
/// Measured: of a patient's own labels 0.95 in a real CT on 3 mm (0.93 with noise of 45 HU, 0.90
/// with 80), 0.99 in synthetic patients; of a patient of another seed on the same grid, whose bones
/// differ by 1 mm, 0.80; of own labels that are shifted by a voxel 0.59 to 0.90, that are a voxel
/// too wide 0.62: so this is no reason to refuse them.
std::optional<std::string> DoubtAboutLabels(const CtVolume& ct, const LabelMap& labels);

inline constexpr double kLeastShare = 0.6;
inline constexpr double kLeastEdgeShare = 0.85;

}  // namespace acus::volume
