// Beamformed RF lines as a MetaImage that PLUS reads.
#pragma once

#include <filesystem>

#include "acus/imaging/rf/beamform.h"

namespace acus::rf {

/// The real part of every column as one RF line: 16-bit, UltrasoundImageType RF_REAL, orientation
/// FM (samples along a line first, then lines to the marked side), one frame. The largest magnitude
/// becomes 32767; the field RfScale restores the values. Whole or not at all.
/// @throws InputError if the image is empty or cannot be written.
void WriteRfLines(const std::filesystem::path& path, const IqImage& image);

}  // namespace acus::rf
