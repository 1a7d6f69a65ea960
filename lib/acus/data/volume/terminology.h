// Codes that other programs have for segments: SNOMED CT, as DICOM and 3D Slicer use it.
#pragma once

#include <string>
#include <string_view>

#include "acus/data/volume/value_names.h"

namespace acus::volume {

/// The value of the tag TerminologyEntry of a segment in `.seg.nrrd`: name of the list, category,
/// type, an empty modifier, and no region. Types are those of 3D Slicer's General Anatomy list or
/// of DICOM's master list (CID 7150 and below); a name that has none there is "Tissue".
/// @param name  Of a standard label; any other name is taken as well.
std::string TerminologyEntry(std::string_view name);

/// The codes in the tags of a segment (TerminologyEntry): type and region, each with its side. The
/// text stays empty. Nothing of tags that are not understood.
ValueName TermsFrom(std::string_view tags);

/// "left" or "right" if a SNOMED CT code means that, otherwise empty.
std::string SideOfCode(std::string_view code);

}  // namespace acus::volume
