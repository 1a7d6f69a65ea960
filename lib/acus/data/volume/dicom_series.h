// From DICOM slices to one CT volume.
#pragma once

#include <filesystem>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"

namespace acus::volume {

/// Reads one series of a DICOM folder; see ReadCt.
///
/// Slices of a tilted gantry are shifted within their planes onto a rectangular grid (linear
/// interpolation; the grid grows to hold them all). Slice steps that differ by more than 2 % are
/// refused: a gap would be filled with anatomy that is not there.
CtVolume ReadDicomCt(const std::filesystem::path& folder, const std::string& series,
                     const RunContext& context);

/// A table of the series of a folder (searched recursively), largest first: slices, spacing and
/// field of view (mm), modality, range of values (HU), folder, description, UID.
/// @throws InputError if there is no readable DICOM image in it.
std::string SeriesTable(const std::filesystem::path& folder, const RunContext& context);

}  // namespace acus::volume
