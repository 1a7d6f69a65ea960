#include "acus/patient/meshing/surface_groups.h"

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

#include "acus/base/core/error.h"

namespace acus::meshing {
namespace {

/// Faces between voxels of `label` and voxels of each other label.
std::array<std::size_t, 256> TouchingFaces(const volume::LabelMap& labels, int label) {
  std::array<std::size_t, 256> out{};
  const Eigen::Array3i& size = labels.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const volume::Label here = labels.At(i, j, k);
        for (int d = 0; d < 3; ++d) {
          const Eigen::Array3i next(i + (d == 0), j + (d == 1), k + (d == 2));
          if ((next >= size).any()) continue;
          const volume::Label there = labels.At(next[0], next[1], next[2]);
          if (here == there) continue;
          if (here == label) ++out[there];
          if (there == label) ++out[here];
        }
      }
    }
  }
  return out;
}

/// Tissues without a surface of their own go with the conforming one that they touch most: a lesion
/// is then distinguished within the liver, and both get their volumes.
void JoinNeighbours(const volume::LabelMap& labels, const std::vector<int>& joining,
                    MaterialOfLabel& materials) {
  for (const int label : joining) {
    const auto faces = TouchingFaces(labels, label);
    std::size_t most = 0;
    for (int other = 1; other < 256; ++other) {
      if (faces[other] <= most || std::ranges::count(joining, other) > 0) continue;
      most = faces[other];
      materials[label] = materials[other];
    }
  }
}

}  // namespace

std::string NameOf(const volume::LabelMap& labels, int label) {
  const auto name = labels.names.find(static_cast<volume::Label>(label));
  return name != labels.names.end() ? name->second : "label " + std::to_string(label);
}

LabelVolumes VolumesMm3(const volume::LabelMap& labels) {
  std::array<std::size_t, 256> counts{};
  for (const volume::Label label : labels.voxels) ++counts[label];
  LabelVolumes out{};
  for (int l = 0; l < 256; ++l) {
    out[l] = static_cast<double>(counts[l]) * labels.geometry.voxel_volume_mm3();
  }
  return out;
}

double BodyMm3(const LabelVolumes& volumes) {
  return std::accumulate(volumes.begin() + 1, volumes.end(), 0.0);
}

bool AllConform(const LabelMeshSettings& settings) {
  return std::ranges::count(settings.conforming_tissues, "all") > 0;
}

SurfaceGroups GroupsOf(const volume::LabelMap& labels, const LabelVolumes& map_mm3,
                       const LabelMeshSettings& settings) {
  SurfaceGroups groups;
  MaterialOfLabel& out = groups.material_of_label;
  std::fill(out.begin() + 1, out.end(), std::uint8_t{1});
  const auto& wanted = settings.conforming_tissues;
  const bool all_conform = AllConform(settings);
  const auto largest = std::max_element(map_mm3.begin() + 1, map_mm3.end()) - map_mm3.begin();
  std::vector<int> joining;
  for (int l = 1; l < 256; ++l) {
    if (map_mm3[l] <= 0.0 || (all_conform && l == largest)) continue;
    if (!all_conform && std::ranges::count(wanted, NameOf(labels, l)) == 0) continue;
    if (std::ranges::count(settings.except_tissues, NameOf(labels, l)) > 0) {
      joining.push_back(l);
      continue;
    }
    ACUS_REQUIRE(groups.num_materials < 64, "more than 62 conforming tissues; list fewer");
    out[l] = static_cast<std::uint8_t>(groups.num_materials++);
  }
  JoinNeighbours(labels, joining, out);
  return groups;
}

}  // namespace acus::meshing
