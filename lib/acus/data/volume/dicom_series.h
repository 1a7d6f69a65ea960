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

}  // namespace acus::volume
