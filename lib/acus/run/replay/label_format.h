// File formats of label images.
#pragma once

#include <map>
#include <string>

namespace acus::replay {

enum class LabelFormat { kNone, kPng, kNifti, kHdf5 };

/// Formats by their names on the command line.
std::map<std::string, LabelFormat> LabelFormats();

}  // namespace acus::replay
