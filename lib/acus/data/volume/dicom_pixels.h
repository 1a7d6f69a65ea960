// The pixels of one DICOM slice.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "acus/data/volume/dicom_header.h"

namespace acus::volume {

/// Decodes a slice to Hounsfield units: columns x rows, padding as -1024, at most 32767.
/// @throws InputError if the pixels are cut off, broken, compressed in a way that GDCM does not
///     read, or not grey with 8 or 16 bits.
std::vector<std::int16_t> DecodedSlice(const DicomHeader& header);

/// The stored values of all frames of an object, one after the other, from the fragments of its
/// compressed pixels. @throws InputError as above.
std::string DecodedFrames(const DicomHeader& header, const std::string& fragments);

}  // namespace acus::volume
