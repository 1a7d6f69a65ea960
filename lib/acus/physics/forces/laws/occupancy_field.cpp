#include "acus/physics/forces/laws/occupancy_field.h"

#include <algorithm>
#include <vector>

namespace acus::forces {
namespace {

/// A share of 1, 2, 1 quarters along one axis; the border continues as it is.
void SmoothAlong(volume::CtVolume& grid, int axis) {
  const Eigen::Array3i size = grid.geometry.size;
  const int length = size[axis];
  const int u = (axis + 1) % 3;
  const int v = (axis + 2) % 3;
  std::vector<std::int16_t> line(static_cast<std::size_t>(length));
  Eigen::Array3i at;
  const auto value = [&](int i) -> std::int16_t& {
    at[axis] = i;
    return grid.At(at[0], at[1], at[2]);
  };
  for (at[u] = 0; at[u] < size[u]; ++at[u]) {
    for (at[v] = 0; at[v] < size[v]; ++at[v]) {
      for (int i = 0; i < length; ++i) line[static_cast<std::size_t>(i)] = value(i);
      for (int i = 0; i < length; ++i) {
        const int before = line[static_cast<std::size_t>(std::max(i - 1, 0))];
        const int after = line[static_cast<std::size_t>(std::min(i + 1, length - 1))];
        value(i) = static_cast<std::int16_t>(
            (before + 2 * line[static_cast<std::size_t>(i)] + after + 2) / 4);
      }
    }
  }
}

volume::CtVolume OccupancyOf(const volume::LabelMap& labels, const std::bitset<256>& tissues) {
  volume::CtVolume grid(labels.geometry);
  for (std::size_t i = 0; i < grid.voxels.size(); ++i) {
    grid.voxels[i] = tissues.test(labels.voxels[i]) ? OccupancyField::kFull : 0;
  }
  for (int axis = 0; axis < 3; ++axis) SmoothAlong(grid, axis);
  return grid;
}

}  // namespace

OccupancyField::OccupancyField(const volume::LabelMap& labels, const std::bitset<256>& tissues)
    : grid_(OccupancyOf(labels, tissues)), field_(grid_) {}

}  // namespace acus::forces
