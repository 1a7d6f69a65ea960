// Label maps made elsewhere, translated by a table.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "acus/base/core/run_context.h"
#include "acus/data/volume/volume.h"

namespace acus::segmentation {

/// A table from the values of a foreign label map to standard tissues; configs/label_maps.
struct LabelMapping {
  std::map<std::int32_t, volume::Label> tissue;  ///< By value. 0 (outside) = leave as it is.
  std::map<std::int32_t, std::string> name;      ///< What the value means where it comes from.
  bool covers_body = false;                      ///< Every voxel of the body has a value above 0.
  bool all_bones = false;                        ///< What is no bone in it is none.
};

/// @throws InputError if the file does not fit its schema, gives a value twice or names a tissue
///     that is not a standard label.
LabelMapping ReadLabelMapping(const std::filesystem::path& path);

/// Values at the places of another grid: as they are if it is the same, otherwise by nearest voxel
/// (with a warning), 0 outside.
/// @throws InputError with both extents if the two share less than 1 % of `grid`.
volume::Grid<std::int32_t> ValuesOnGrid(const volume::Grid<std::int32_t>& from,
                                        const volume::Geometry& grid,
                                        const std::filesystem::path& path,
                                        const RunContext& context);

/// The tissues of values; none where a value maps to none. @throws InputError naming all values
/// that are not in the table.
volume::LabelMap Translated(const volume::Grid<std::int32_t>& values, const LabelMapping& mapping,
                            const std::filesystem::path& path);

/// Where `over` has a tissue, `labels` takes it.
void Overlay(const volume::LabelMap& over, volume::LabelMap& labels);

}  // namespace acus::segmentation
