// Volumes and label maps on disk.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"

namespace acus::volume {

/// One image series of a DICOM folder.
struct DicomSeries {
  std::string uid;
  std::string description;
  int temporal_position = 0;                 ///< Of a scan over time; 0: none.
  std::vector<std::filesystem::path> files;  ///< In order along the slice normal.
  Eigen::Array2i image_size;                 ///< Columns, rows.
};

/// The series of a DICOM folder (searched recursively), largest first.
/// @throws InputError if there is no readable DICOM image in it.
std::vector<DicomSeries> ListDicomSeries(const std::filesystem::path& folder);

/// Reads a CT: a DICOM folder or multi-frame file, or a NIfTI, NRRD or MetaImage file.
///
/// Values are Hounsfield units; padding (below -1024) becomes -1024, values above 32767 are cut
/// off.
/// @param series  UID, or a part of it or of the description, that picks one of several series.
///     If empty, a folder with one CT-like series (at least 3 parallel, evenly spaced slices) reads
///     that. Of a NIfTI file with several volumes over time: the number of one, from 1 on.
/// @throws InputError if the format is unknown, the file is cut off or broken, slices are missing
///     or uneven, the choice of series is open (the message lists them), or the JSON file beside a
///     NIfTI file (BIDS) says that it is no CT in HU.
CtVolume ReadCt(const std::filesystem::path& path, const std::string& series,
                const RunContext& context);

/// Reads a label map; names come from `.seg.nrrd` segment keys where there are any, otherwise from
/// the standard labels. @throws InputError as above, or if a value does not fit a Label.
LabelMap ReadLabelMap(const std::filesystem::path& path);

/// A label map in the standard numbers, which the models go by: a segment that is named as a
/// standard tissue gets its number, whatever number the file gives it. Labels beyond the standard
/// ones keep theirs.
/// @throws InputError as ReadLabelMap, and if a standard number bears another name.
LabelMap ReadTissues(const std::filesystem::path& path);

/// Reads a file of integer labels made elsewhere, as it is. VTI is read too.
/// @param keys  If given: takes the text fields of the header.
Grid<std::int32_t> ReadIntegerVolume(const std::filesystem::path& path,
                                     std::map<std::string, std::string>* keys = nullptr);

/// The layers of an NRRD with several values for each voxel (see NrrdLayers).
std::vector<Grid<std::int32_t>> ReadIntegerLayers(const std::filesystem::path& path, int layers,
                                                  std::map<std::string, std::string>& keys);

/// Writes NIfTI, NRRD or MetaImage, by extension; atomically, compressed.
void WriteCt(const std::filesystem::path& path, const CtVolume& volume);

/// Writes a `.seg.nrrd` that 3D Slicer opens as a segmentation (names, colours), atomically.
void WriteLabelMap(const std::filesystem::path& path, const LabelMap& labels);

}  // namespace acus::volume
