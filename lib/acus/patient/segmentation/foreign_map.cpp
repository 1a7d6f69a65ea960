#include "acus/patient/segmentation/foreign_map.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/data/volume/dicom_segmentation.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/volume_io.h"
#include "acus/patient/segmentation/label_json.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;

/// One structure of a folder: the places of its voxels.
struct MaskFile {
  std::string name;
  std::vector<std::uint32_t> voxels;
};

std::vector<std::uint32_t> VoxelsOf(const volume::Grid<std::int32_t>& mask, const fs::path& file) {
  ACUS_REQUIRE(mask.voxels.size() < 0xFFFFFFFFU, file.string(), ": has ", mask.voxels.size(),
               " voxels; masks of a folder have less than 2^32");
  std::vector<std::uint32_t> voxels;
  std::int32_t first = 0;
  for (std::size_t n = 0; n < mask.voxels.size(); ++n) {
    const std::int32_t value = mask.voxels[n];
    if (value == 0) continue;
    if (first == 0) first = value;
    ACUS_REQUIRE(value == first, file.string(), ": has the values ", first, " and ", value,
                 "; a folder holds one mask for each structure. Give a file with several labels "
                 "itself, not its folder");
    voxels.push_back(static_cast<std::uint32_t>(n));
  }
  return voxels;
}

std::vector<fs::path> FilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

/// Values are 1, 2, ... in the order of the names.
volume::NamedValues FromMasks(const std::vector<fs::path>& files) {
  volume::NamedValues map;
  std::vector<MaskFile> masks;
  for (const fs::path& file : files) {
    const volume::Grid<std::int32_t> mask = volume::ReadIntegerVolume(file);
    if (masks.empty()) map.values = volume::Grid<std::int32_t>(mask.geometry);
    ACUS_REQUIRE(mask.geometry.Matches(map.values.geometry), file.string(),
                 ": lies on another grid than ", files.front().filename().string(),
                 "; the masks of a folder need one grid");
    masks.push_back({.name = StemOf(file), .voxels = VoxelsOf(mask, file)});
  }
  std::vector<std::size_t> order(masks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return masks[a].voxels.size() > masks[b].voxels.size();
  });
  for (const std::size_t n : order) {
    const auto value = static_cast<std::int32_t>(n + 1);
    for (const std::uint32_t voxel : masks[n].voxels) map.values.voxels[voxel] = value;
    map.names[value] = {.text = masks[n].name, .codes = {}};
  }
  map.named_by = "by the names of its files";
  return map;
}

volume::NamedValues FromFolder(const fs::path& folder) {
  std::vector<fs::path> masks, segmentations;
  for (const fs::path& file : FilesIn(folder)) {
    if (volume::IsScalarFileName(file)) {
      masks.push_back(file);
    } else if (file.extension() == ".dcm" && volume::IsDicomSegmentation(file)) {
      segmentations.push_back(file);
    }
  }
  if (!masks.empty()) return FromMasks(masks);
  ACUS_REQUIRE(segmentations.size() == 1, folder.string(), ": holds ", segmentations.size(),
               " DICOM segmentation objects and no NIfTI, NRRD or MetaImage masks; give a folder "
               "with one mask for each structure, or the file itself");
  return volume::ReadNamedValues(segmentations.front());
}

}  // namespace

volume::NamedValues ReadForeignMap(const fs::path& path) {
  if (fs::is_directory(path)) return FromFolder(path);
  volume::NamedValues map = volume::ReadNamedValues(path);
  if (!map.names.empty()) return map;  // Written with the values: nothing beside it is nearer.
  NamesBeside beside = FindNamesBeside(path);
  if (!beside.names.empty()) map.named_by = "by " + beside.file.filename().string();
  map.names = std::move(beside.names);
  return map;
}

std::string StemOf(const fs::path& file) {
  std::string name = file.filename().string();
  for (const char* ending :
       {".gz", ".nii", ".nrrd", ".nhdr", ".seg", ".mha", ".mhd", ".vti", ".dcm"}) {
    if (name.ends_with(ending)) name.erase(name.size() - std::string(ending).size());
  }
  return name;
}

}  // namespace acus::segmentation
