// Label maps made elsewhere: one file, or a folder with one mask for each structure.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/data/volume/named_values.h"

namespace acus::segmentation {

/// Reads a label map and all names of its values that it or a file beside it gives.
///
/// A folder with volumes has one mask for each structure, named by the file (`spleen.nii.gz`); all
/// masks lie on one grid. Where masks overlap, the one with fewer voxels remains: a tumour in the
/// liver, the liver in the body. A folder with a single DICOM segmentation object or structure set
/// (RTSTRUCT) is that.
/// @param ct  The grid of the CT, on which the contours of a structure set are filled.
/// @param frame_uids  As of ReadStructureSet.
/// @throws InputError if a file is broken, a mask has several values, or the folder has neither.
volume::NamedValues ReadForeignMap(const std::filesystem::path& path, const volume::Geometry& ct,
                                   const std::vector<std::string>& frame_uids = {});

/// The DICOM segmentation object or structure set that a path is, or the one that its folder holds;
/// empty if it is something else.
std::filesystem::path DicomLabelsIn(const std::filesystem::path& path);

}  // namespace acus::segmentation
