// One image file in memory, as it is on disk: the common ground of all volume readers and writers.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "acus/data/volume/geometry.h"

namespace acus::volume {

enum class ScalarType {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64
};

/// Scalars of one type on a 3-D grid, little or big endian as the machine is.
struct ScalarFile {
  Geometry geometry;
  ScalarType type = ScalarType::kInt16;
  int num_components = 1;                   ///< Scalars per voxel; 3: a vector.
  std::vector<std::byte> bytes;             ///< num_components for each voxel.
  std::map<std::string, std::string> keys;  ///< Text fields of the header (NRRD key := value).
  std::vector<std::string> notes = {};      ///< What was repaired when it was read.
  bool is_placed = true;                    ///< The header says how the patient lies.
};

std::size_t BytesOf(ScalarType type);

/// True if the name ends like a format that ReadScalarFile reads (.nii, .nii.gz, .nrrd, .nhdr,
/// .mha, .mhd).
bool IsScalarFileName(const std::filesystem::path& path);

/// The file's name without the endings of volumes, label maps and DICOM files: "spleen" of
/// "a/spleen.nii.gz" and "spleen.seg.nrrd".
std::string VolumeStem(const std::filesystem::path& path);

/// Reads NIfTI, NRRD or MetaImage, by extension. The direction of the result is right-handed: the
/// slices of a left-handed file are taken in reverse order.
/// @throws InputError if the file is broken, cut off, not a single 3-D scalar volume, or its
///     voxel axes are not perpendicular.
ScalarFile ReadScalarFile(const std::filesystem::path& path);

/// How many volumes over time a file holds, of which ReadVolumeOf reads one; 1 for all formats but
/// NIfTI. @throws InputError if it is a NIfTI file with a broken header.
int NumVolumes(const std::filesystem::path& path);

/// The same for one of them. @param number  From 0 on.
ScalarFile ReadVolumeOf(const std::filesystem::path& path, int number);

/// The same for a file of three numbers per voxel.
ScalarFile ReadVectorFile(const std::filesystem::path& path);

/// The same for a file of `num_components` numbers per voxel.
ScalarFile ReadLayeredFile(const std::filesystem::path& path, int num_components);

/// Writes NIfTI, NRRD or MetaImage, by extension; compressed; not atomically.
/// @throws InputError if the extension is none of .nii, .nii.gz, .nrrd, .mha, or writing fails.
void WriteScalarFile(const std::filesystem::path& path, const ScalarFile& file);

/// Reverses the slices if `file.geometry.direction` has a negative determinant.
void MakeRightHanded(ScalarFile& file);

/// @throws InputError if the geometry is not usable: an empty or negative size, spacing that is
///     not positive or finite, axes that are not perpendicular unit vectors.
void RequireUsable(const Geometry& geometry, const std::filesystem::path& path);

}  // namespace acus::volume
