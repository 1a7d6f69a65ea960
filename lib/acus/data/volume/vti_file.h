// VTK's image files.
#pragma once

#include <filesystem>

#include "acus/data/volume/scalar_file.h"

namespace acus::volume {

/// Reads the first point scalar of a `.vti`. The axes are taken as LPS, and one piece only.
/// @throws InputError if the file is broken, cut off, or larger in its header than on disk.
ScalarFile ReadVtiFile(const std::filesystem::path& path);

}  // namespace acus::volume
