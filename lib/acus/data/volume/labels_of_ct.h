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

inline constexpr double kLeastShare = 0.6;

}  // namespace acus::volume
