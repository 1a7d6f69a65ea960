#include "acus/data/volume/named_values.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "acus/base/core/error.h"
#include "acus/data/volume/dicom_segmentation.h"
#include "acus/data/volume/header_check.h"
#include "acus/data/volume/nifti_label_table.h"
#include "acus/data/volume/packed_nifti.h"
#include "acus/data/volume/scalar_file.h"
#include "acus/data/volume/segment_keys.h"
#include "acus/data/volume/volume_io.h"

namespace acus::volume {

namespace {

constexpr const char* kBySegments = "by the names of its segments";

/// A segmentation of 3D Slicer whose segments overlap.
NamedValues FromLayers(const std::filesystem::path& path, int layers) {
  std::map<std::string, std::string> keys;
  const auto grids = ReadIntegerLayers(path, layers, keys);
  std::vector<NamedMask> masks;
  for (const LayeredSegment& segment : SegmentsFromKeys(keys, path.string())) {
    ACUS_REQUIRE(segment.layer < layers, path.string(), ": segment '", segment.name.text,
                 "' is in layer ", segment.layer, ", but there are ", layers, "; export it again");
    masks.push_back(
        {.name = segment.name,
         .voxels = VoxelsWhere(grids[static_cast<std::size_t>(segment.layer)], path.string(),
                               [&](std::int32_t value) { return value == segment.value; })});
  }
  ACUS_REQUIRE(!masks.empty(), path.string(), ": has ", layers,
               " values for each voxel and no segments (Segment0_Name, ...); a label map has one");
  NamedValues map = Merged(masks, grids.front().geometry);
  map.named_by = kBySegments;
  return map;
}

}  // namespace

NamedValues Merged(const std::vector<NamedMask>& masks, const Geometry& grid) {
  NamedValues map;
  map.values = Grid<std::int32_t>(grid);
  std::vector<std::size_t> order(masks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, std::ranges::greater(),
                           [&](std::size_t n) { return masks[n].voxels.size(); });
  for (const std::size_t n : order) {
    const auto value = static_cast<std::int32_t>(n + 1);
    for (const std::uint32_t voxel : masks[n].voxels) map.values.voxels[voxel] = value;
    map.names[value] = masks[n].name;
  }
  return map;
}

NamedValues ReadNamedValues(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  if (!IsScalarFileName(path) && path.extension() != ".vti" && IsDicomSegmentation(path)) {
    return ReadDicomSegmentation(path);
  }
  const bool is_nrrd = name.ends_with(".nrrd") || name.ends_with(".nhdr");
  const int layers = is_nrrd && std::filesystem::is_regular_file(path) ? NrrdLayers(path) : 1;
  if (layers > 1) return FromLayers(path, layers);
  NamedValues map;
  std::map<std::string, std::string> keys;
  map.values = ReadIntegerVolume(path, &keys);
  if (name.ends_with(".nii") || name.ends_with(".nii.gz") || name.ends_with(".nii.bz2")) {
    const auto copy = UnpackedNifti(path);
    map.names = NiftiLabelTable(copy ? copy->path() : path);
    if (!map.names.empty()) map.named_by = "by the label table in its header";
  } else {
    for (LayeredSegment& segment : SegmentsFromKeys(keys, path.string())) {
      map.names[segment.value] = std::move(segment.name);
    }
    if (!map.names.empty()) map.named_by = kBySegments;
  }
  return map;
}

}  // namespace acus::volume
