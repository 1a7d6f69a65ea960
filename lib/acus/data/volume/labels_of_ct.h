// Whether a label map is that of a CT: bone and gas have Hounsfield units that nothing else has.
#pragma once

#include <optional>
#include <string>

#include "acus/data/volume/volume.h"

namespace acus::volume {

/// Why the labels cannot be those of the CT: the share of a tissue's voxels that have its HU in the
/// CT is below kLeastShare, or the share of the edges of bone across which the HU fall outwards is
/// below kLeastEdgeShare. Nothing if they fit, or have too little bone, lung and gas to judge by.
/// The grids may differ.
///
/// Bone: 60 HU or more; lung and gas: -200 HU or less. Measured: of a patient's own labels 0.85 to
/// 1.00 of the bone and 0.99 of the lung, in a real CT on 3 mm and in synthetic patients; of other
/// patients' or shifted labels 0.00 to 0.50. Edges: of a patient's own labels 0.96 in a real CT on
/// 3 mm and 0.99 in synthetic patients; of a patient of another seed on the same grid, whose bones
/// differ by 1 mm, 0.80 and 0.81; of own labels that are shifted by a voxel 0.59 to 0.90.
std::optional<std::string> WhyLabelsAreOfAnother(const CtVolume& ct, const LabelMap& labels);

inline constexpr double kLeastShare = 0.6;
inline constexpr double kLeastEdgeShare = 0.85;

}  // namespace acus::volume
