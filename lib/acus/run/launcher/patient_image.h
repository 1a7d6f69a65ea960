// Images of a patient and of what is to be done in it, for a list to choose from.
#pragma once

#include <filesystem>

#include "acus/base/core/run_context.h"
#include "acus/data/image/image.h"
#include "acus/data/volume/volume.h"

namespace acus::launcher {

/// The slice of a CT that contains the planned path, which goes downward in it: the path as a line
/// and the target as a ring. Outside the CT it is black.
/// @param side_px  Width and height. 1.25 times the path, 120 mm at least, is in the image.
image::ColourImage PathImage(const volume::CtVolume& ct, const Eigen::Vector3d& entry_in_ct_mm,
                             const Eigen::Vector3d& target_in_ct_mm, int side_px);

/// The same for a workplace, whose scenario names the CT and whose path is in
/// patient/corridor_ct.csv.
/// @throws InputError if one of these files is missing or cannot be read.
image::ColourImage ImageOf(const std::filesystem::path& workplace, int side_px,
                           const RunContext& context);

}  // namespace acus::launcher
