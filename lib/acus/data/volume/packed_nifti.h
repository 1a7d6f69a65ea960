// NIfTI files that are compressed in a way which ITK does not read.
#pragma once

#include <filesystem>
#include <memory>

#include "acus/base/core/temporaries.h"

namespace acus::volume {

/// A plain copy (.nii) of a file that is compressed by bzip2 (.nii.bz2), or by gzip without its
/// name saying so, or is not compressed though its name says so. What the file begins with decides.
/// @returns nothing if ITK reads the file as it is, or it is no NIfTI file by its name.
/// @throws InputError if its data are damaged, or become more than `--memory-gb` allows, or more
/// than
///     2 GB and 100 times the file's size.
std::unique_ptr<Temporary> UnpackedNifti(const std::filesystem::path& path);

}  // namespace acus::volume
