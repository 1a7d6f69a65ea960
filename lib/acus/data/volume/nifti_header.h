// The header of NIfTI files, in both versions, and forms of it that ITK does not read.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "acus/base/core/temporaries.h"

namespace acus::volume {

/// A header in the layout of NIfTI-1, in the byte order of the file. One of NIfTI-2 is converted;
/// its voxels begin where At<float>(108) says.
struct NiftiHeader {
  bool swapped = false;
  bool is_version_2 = false;
  double mm_per_unit = 1.0;  ///< Of the lengths in the file, as xyzt_units says; here they are mm.
  std::array<std::uint8_t, 352> bytes{};

  template <typename T>
  T At(std::size_t offset) const {
    std::array<std::uint8_t, sizeof(T)> raw{};
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      raw[i] = bytes[offset + (swapped ? sizeof(T) - 1 - i : i)];
    }
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

  template <typename T>
  void Set(std::size_t offset, T value) {
    std::array<std::uint8_t, sizeof(T)> raw{};
    std::memcpy(raw.data(), &value, sizeof(T));
    for (std::size_t i = 0; i < sizeof(T); ++i) {
      bytes[offset + (swapped ? sizeof(T) - 1 - i : i)] = raw[i];
    }
  }
};

/// How many volumes over time a header declares: 1 for one volume.
int NiftiVolumes(const NiftiHeader& header);

/// Reads the header of a single file (.nii, .nii.gz). @throws InputError if it is none.
NiftiHeader ReadNiftiHeader(const std::filesystem::path& path);

/// What of a file is to be read.
struct NiftiPart {
  int channels = 1;  ///< Numbers for each voxel.
  int volume = 0;    ///< Of several over time.
};

/// A copy that ITK reads, for a file of NIfTI-2, one whose axes are up to a degree from
/// perpendicular (the nearest rotation is taken), one whose qform and sform place it differently
/// (the one in scanner coordinates is taken, otherwise the sform), one of several volumes over
/// time, one whose vectors are its fourth dimension, and one in metres or micrometres. An intercept
/// beside a slope of 0, which means no scaling, does not count.
/// @param notes  Takes a sentence on what was done.
/// @returns nothing if the file can be read as it is.
/// @throws InputError if the axes are farther from perpendicular, or the forms or pixdim have other
///     spacings.
/// @pre the header has been checked (CheckNiftiHeader).
std::unique_ptr<Temporary> ReadableNifti(const std::filesystem::path& path, const NiftiPart& part,
                                         std::vector<std::string>& notes);

}  // namespace acus::volume
