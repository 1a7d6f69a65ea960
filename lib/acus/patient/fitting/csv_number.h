// A number in a cell of a recording.
#pragma once

#include <string>

namespace acus::fitting {

/// @throws InputError that begins with `where` if the cell is not a finite number below 1e6.
double NumberAt(const std::string& cell, const std::string& where, const char* what);

}  // namespace acus::fitting
