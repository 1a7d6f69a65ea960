#include "acus/patient/segmentation/import/label_mapping.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "acus/base/config/json_file.h"
#include "acus/base/core/parallel.h"
#include "acus/data/volume/labels.h"

namespace acus::segmentation {
namespace {

namespace fs = std::filesystem;

constexpr double kLeastOverlap = 0.01;

/// "x -120 to 130, y ..., z ... mm": between the outermost voxel centres.
std::string Extent(const volume::Geometry& grid) {
  Eigen::AlignedBox3d box;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Array3i at(corner & 1, corner >> 1 & 1, corner >> 2);
    box.extend(grid.ct_from_index() * (at * (grid.size - 1)).cast<double>().matrix());
  }
  const auto range = [&](const char* axis, int d) {
    return Message(axis, " ", std::round(box.min()[d]), " to ", std::round(box.max()[d]));
  };
  return Message(range("x", 0), ", ", range("y", 1), ", ", range("z", 2), " mm");
}

}  // namespace

volume::Grid<std::int32_t> ValuesOnGrid(const volume::Grid<std::int32_t>& from,
                                        const volume::Geometry& grid, const fs::path& path,
                                        const RunContext& context) {
  if (from.geometry.Matches(grid)) return from;
  volume::Grid<std::int32_t> out(grid, 0);
  std::vector<std::size_t> hits(static_cast<std::size_t>(grid.size[2]), 0);
  const Eigen::Affine3d from_index_to_index = from.geometry.index_from_ct() * grid.ct_from_index();
  ParallelFor(grid.size[2], context.num_threads, [&](int k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const Eigen::Vector3d at = from_index_to_index * Eigen::Vector3d(i, j, k);
        const Eigen::Array3i voxel = at.array().round().cast<int>();
        if (!from.geometry.Contains(voxel[0], voxel[1], voxel[2])) continue;
        out.At(i, j, k) = from.At(voxel[0], voxel[1], voxel[2]);
        ++hits[static_cast<std::size_t>(k)];
      }
    }
  });
  std::size_t total = 0;
  for (const std::size_t h : hits) total += h;
  const double share = static_cast<double>(total) / static_cast<double>(grid.num_voxels());
  ACUS_REQUIRE(share >= kLeastOverlap, path.string(), ": does not overlap the CT: it covers ",
               Extent(from.geometry), ", the CT ", Extent(grid),
               " (LPS); are the two from one patient, and both in patient coordinates?");
  context.Warn(Message(path.string(), ": lies on another grid than the CT, of which it covers ",
                       std::round(100.0 * share), " %; labels are taken from the nearest voxel"));
  return out;
}

LabelMapping ReadLabelMapping(const fs::path& path) {
  const nlohmann::json document = config::ReadConfig(path, "acus-label-mapping");
  LabelMapping mapping;
  mapping.covers_body = document.at("covers_body").get<bool>();
  mapping.all_bones = document.at("all_bones").get<bool>();
  for (const auto& row : document.at("labels")) {
    const auto value = row.at("value").get<std::int32_t>();
    const auto tissue = row.at("tissue").get<std::string>();
    ACUS_REQUIRE(!mapping.tissue.contains(value), path.string(), ": value ", value,
                 " is given twice");
    try {
      mapping.tissue[value] = volume::LabelOf(tissue);
    } catch (const InputError& error) {
      throw InputError(Message(path.string(), ": value ", value, ": ", error.what()));
    }
    mapping.name[value] = row.at("name").get<std::string>();
  }
  return mapping;
}

volume::LabelMap Translated(const volume::Grid<std::int32_t>& values, const LabelMapping& mapping,
                            const fs::path& path) {
  volume::LabelMap labels(values.geometry);
  std::set<std::int32_t> unknown;
  std::int32_t last_value = 0;
  volume::Label last_label = 0;
  for (std::size_t i = 0; i < values.voxels.size(); ++i) {
    const std::int32_t value = values.voxels[i];
    if (value == 0) continue;
    if (value != last_value) {  // Most voxels have the value of the previous one.
      const auto found = mapping.tissue.find(value);
      if (found == mapping.tissue.end()) {
        unknown.insert(value);
        continue;
      }
      last_value = value;
      last_label = found->second;
    }
    labels.voxels[i] = last_label;
    if (last_label != 0)
      labels.names[last_label] = std::string(volume::StandardLabels()[last_label].name);
  }
  constexpr std::size_t kMostValuesListed = 20;
  std::string listed;
  std::size_t num_listed = 0;
  for (const std::int32_t value : unknown) {
    if (++num_listed <= kMostValuesListed) listed += Message(" ", value);
  }
  if (num_listed > kMostValuesListed) {
    listed += Message(" and ", num_listed - kMostValuesListed, " more");
  }
  ACUS_REQUIRE(unknown.empty(), path.string(), ": values that are not in the mapping:", listed,
               "; add them to it (tissue 'outside' for what should be ignored), or give another "
               "table by --mapping");
  return labels;
}

void Overlay(const volume::LabelMap& over, volume::LabelMap& labels) {
  ACUS_ASSERT(over.voxels.size() == labels.voxels.size());
  for (std::size_t i = 0; i < over.voxels.size(); ++i) {
    if (over.voxels[i] != 0) labels.voxels[i] = over.voxels[i];
  }
  labels.names.insert(over.names.begin(), over.names.end());
}

}  // namespace acus::segmentation
