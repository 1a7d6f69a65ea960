// DICOM radiotherapy structure sets (RTSTRUCT): PS3.3, A.19 and C.8.8.5 to C.8.8.8.
#pragma once

#include <filesystem>

#include "acus/data/volume/named_values.h"

namespace acus::volume {

/// True for a DICOM file with modality RTSTRUCT. @throws InputError if it is DICOM, but broken.
bool IsStructureSet(const std::filesystem::path& path);

/// Fills the closed contours of each region of interest (ROI) on the grid of the CT that they were
/// drawn on. Values are 1, 2, ... in the order of the file, names are ROI names, codes those of
/// the observations.
///
/// A voxel is inside if its centre is inside an odd number of the contours of its plane: inner
/// contours are holes, keyhole contours leave one, and identical copies of a contour count once. A
/// slice of the CT without a contour takes the contours of the nearest plane within half of the
/// ROI's distance between planes. ROIs that are no part of the body (PTV, support, marker, ...) are
/// omitted, and so are ROIs of another frame of reference if one is of `frame_uids`; `named_by`
/// says which. Where ROIs overlap, the one with fewer voxels remains.
/// @param frame_uids  Frame of Reference UID of the CT; empty: not known.
/// @throws InputError if the file is broken, contours do not lie in planes of the grid, or none of
///     them holds a voxel of it.
NamedValues ReadStructureSet(const std::filesystem::path& path, const Geometry& grid,
                             const std::vector<std::string>& frame_uids = {});

}  // namespace acus::volume
