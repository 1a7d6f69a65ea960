// Codes by which other programs know what a segment is: SNOMED CT, as DICOM and 3D Slicer use it.
#pragma once

#include <string>
#include <string_view>

namespace acus::volume {

/// The value of the tag TerminologyEntry of a segment in `.seg.nrrd`: name of the list, category,
/// type, an empty modifier, and no region. Types are those of 3D Slicer's General Anatomy list or
/// of DICOM's master list (CID 7150 and below); a name that has none there is "Tissue".
/// @param name  Of a standard label; any other name is taken as well.
std::string TerminologyEntry(std::string_view name);

}  // namespace acus::volume
