// Header checks before a third-party reader sees a file: it would trust the sizes in there.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace acus::volume {

/// The most bytes of voxels that a file of a format can hold, from the sizes on disk alone. Deflate
/// cannot shrink data to less than 1/1032.
/// Detached data (.nhdr, .mhd) is sought in the folder of the header.
std::uint64_t MostVoxelBytes(const std::filesystem::path& path);

/// Reads the text header of a MetaImage (.mha, .mhd) and refuses what its reader cannot survive.
/// @param channels  Numbers per voxel: 1, or 3 for displacements.
/// @throws InputError
void CheckMetaImageHeader(const std::filesystem::path& path, int channels = 1);

/// Reads the binary header of a NIfTI file (.nii, .nii.gz) and refuses what its reader cannot
/// survive or would place wrongly.
/// @param one_of_several  The file may hold several volumes over time, of which one is to be read.
/// @throws InputError
void CheckNiftiHeader(const std::filesystem::path& path, int channels = 1,
                      bool one_of_several = false);

/// True if a NIfTI file says where it lies in the patient (qform or sform code above 0).
bool NiftiIsPlaced(const std::filesystem::path& path);

/// Reads the text header of an NRRD (.nrrd, .nhdr) and refuses what its reader cannot survive.
/// @throws InputError
void CheckNrrdHeader(const std::filesystem::path& path, int channels = 1);

/// How many mm the unit of an NRRD's space has ("space units"); 1 if it does not say.
/// @throws InputError if it is no length, or not one for all axes.
double NrrdMillimetresPerUnit(const std::filesystem::path& path);

/// The space of an NRRD, in lower case and written out: "left-posterior-superior". Empty if it does
/// not say how the patient lies.
std::string NrrdSpace(const std::filesystem::path& path);

/// How many values an NRRD has for each voxel: the first of four sizes if that is a list or vector
/// (3D Slicer's layers of a segmentation), otherwise 1.
int NrrdLayers(const std::filesystem::path& path);

}  // namespace acus::volume
