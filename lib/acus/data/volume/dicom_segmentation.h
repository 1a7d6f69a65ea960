// DICOM segmentation objects: PS3.3, A.51 and C.8.20.
#pragma once

#include <filesystem>

#include "acus/data/volume/named_values.h"

namespace acus::volume {

/// True for a DICOM file with modality SEG. @throws InputError if it is DICOM, but broken.
bool IsDicomSegmentation(const std::filesystem::path& path);

/// Reads a segmentation object: binary, fractional (a voxel belongs to a segment from half of the
/// largest value on) or label map. Values are the numbers of the segments; where segments overlap,
/// the higher number remains. Frames that the object omits, because they are empty, are 0. Names
/// are segment labels, codes those of the segmented property and its region.
/// @throws InputError if frames are cut off, compressed, or do not lie on one grid.
NamedValues ReadDicomSegmentation(const std::filesystem::path& path);

}  // namespace acus::volume
