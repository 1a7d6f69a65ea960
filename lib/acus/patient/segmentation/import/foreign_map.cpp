#include "acus/patient/segmentation/import/foreign_map.h"

#include <algorithm>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/data/volume/dicom_segmentation.h"
#include "acus/data/volume/names_beside.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/structure_set.h"
#include "acus/data/volume/volume_io.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;

/// @throws InputError if the mask has two values above 0.
void RequireOneValue(const volume::Grid<std::int32_t>& mask, const fs::path& file) {
  std::int32_t first = 0;
  for (const std::int32_t value : mask.voxels) {
    if (first == 0) first = value;
    ACUS_REQUIRE(value == 0 || value == first, file.string(), ": has the values ", first, " and ",
                 value,
                 "; a folder holds one mask for each structure. Give a file with several "
                 "labels itself, not its folder");
  }
}

std::vector<fs::path> FilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const bool is_hidden = entry.path().filename().string().starts_with('.');  // "._liver.nii.gz"
    if (entry.is_regular_file() && !is_hidden) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

volume::NamedValues FromMasks(const std::vector<fs::path>& files) {
  std::vector<volume::NamedMask> masks;
  volume::Geometry grid;
  for (const fs::path& file : files) {
    const volume::Grid<std::int32_t> mask = volume::ReadIntegerVolume(file);
    if (masks.empty()) grid = mask.geometry;
    ACUS_REQUIRE(mask.geometry.Matches(grid), file.string(), ": lies on another grid than ",
                 files.front().filename().string(), "; the masks of a folder need one grid");
    RequireOneValue(mask, file);
    masks.push_back({.name = {.text = volume::VolumeStem(file), .codes = {}},
                     .voxels = VoxelsWhere(mask, file.string(),
                                           [](std::int32_t value) { return value != 0; })});
  }
  volume::NamedValues map = volume::Merged(masks, grid);
  map.named_by = "by the names of its files";
  return map;
}

bool IsDicomLabels(const fs::path& file) {
  return volume::IsDicomSegmentation(file) || volume::IsStructureSet(file);
}

bool IsDicomName(const fs::path& file) {
  return file.extension() == ".dcm" || file.extension().empty();
}

/// A folder without masks must hold one object, which is read as DICOM.
volume::NamedValues FromFolder(const fs::path& folder) {
  const std::vector<fs::path> files = FilesIn(folder);
  std::vector<fs::path> masks;
  std::ranges::copy_if(files, std::back_inserter(masks), volume::IsScalarFileName);
  if (!masks.empty()) return FromMasks(masks);
  const auto count = std::ranges::count_if(
      files, [](const fs::path& file) { return IsDicomName(file) && IsDicomLabels(file); });
  throw InputError(Message(folder.string(), ": holds ", count,
                           " DICOM segmentations or structure sets and no NIfTI, NRRD or MetaImage "
                           "masks; give a folder with one mask for each structure, or the file "
                           "itself"));
}

}  // namespace

fs::path DicomLabelsIn(const fs::path& path) {
  if (!fs::is_directory(path)) {
    const bool may_be_dicom = !volume::IsScalarFileName(path) && path.extension() != ".vti";
    return may_be_dicom && IsDicomLabels(path) ? path : fs::path();
  }
  std::vector<fs::path> objects;
  for (const fs::path& file : FilesIn(path)) {
    if (volume::IsScalarFileName(file)) return {};  // A folder of masks.
    if (IsDicomName(file) && IsDicomLabels(file)) objects.push_back(file);
  }
  return objects.size() == 1 ? objects.front() : fs::path();
}

volume::NamedValues ReadForeignMap(const fs::path& path, const volume::Geometry& ct,
                                   const std::vector<std::string>& frame_uids) {
  const fs::path object = DicomLabelsIn(path);
  if (!object.empty() && volume::IsStructureSet(object)) {
    return volume::ReadStructureSet(object, ct, frame_uids);
  }
  if (object.empty() && fs::is_directory(path)) return FromFolder(path);
  volume::NamedValues map = volume::ReadNamedValues(object.empty() ? path : object);
  if (!map.names.empty()) return map;  // Written with the values: nothing beside it is nearer.
  volume::NamesBeside beside = volume::FindNamesBeside(path);
  map.is_named_beside = !beside.names.empty();
  if (map.is_named_beside) map.named_by = "by " + beside.file.filename().string();
  map.names = std::move(beside.names);
  return map;
}

}  // namespace acus::segmentation
