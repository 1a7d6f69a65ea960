// The elements of a MATLAB file, looked at before a library takes memory for what they declare.
#pragma once

#include <filesystem>

namespace acus::rf {

/// Walks all elements of a version 5 file (save -v6, -v7; MathWorks, MAT-File Format), compressed
/// ones too. Files of version 7.3 are HDF5, which holds its own elements together.
/// @throws InputError naming the file and the byte: it is of another version or format, an element
///     ends beyond what holds it, or an array declares more values than it has bytes.
void RequireSoundMatlab(const std::filesystem::path& path);

}  // namespace acus::rf
