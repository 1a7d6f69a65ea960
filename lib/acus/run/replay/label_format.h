// In which files label images are written.
#pragma once

#include <map>
#include <string>

namespace acus::replay {

enum class LabelFormat { kNone, kPng, kNifti, kHdf5 };

/// The words of the command line.
std::map<std::string, LabelFormat> LabelFormats();

}  // namespace acus::replay
