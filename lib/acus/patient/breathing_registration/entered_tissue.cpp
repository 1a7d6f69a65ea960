#include "acus/patient/breathing_registration/entered_tissue.h"

#include <algorithm>
#include <cmath>

namespace acus::breathing_registration {
namespace {

constexpr float kLeastMotionVoxels = 0.5F;  // Less cannot be distinguished from no motion.

/// The two axes of a face.
std::array<int, 2> AxesOf(int axis) {
  return {axis == 0 ? 1 : 0, axis == 2 ? 1 : 2};
}

}  // namespace

template <class DepthOf>
void EnteredTissue::FillFaces(const SlidingGrid& grid, const DepthOf& depth_of) {
  for (int f = 0; f < 6; ++f) {
    const int axis = f / 2;
    const bool high = f % 2 == 1;
    const auto [a, b] = AxesOf(axis);
    Face& face = faces_[static_cast<std::size_t>(f)];
    face.depth.assign(static_cast<std::size_t>(size_[a]) * static_cast<std::size_t>(size_[b]),
                      0.0F);
    Eigen::Array3i at;
    at[axis] = high ? size_[axis] - 1 : 0;
    std::size_t column = 0;
    for (at[b] = 0; at[b] < size_[b]; ++at[b]) {
      for (at[a] = 0; at[a] < size_[a]; ++at[a], ++column) {
        const std::int32_t n = grid.NodeAt(grid.geometry().Index(at[0], at[1], at[2]));
        if (n < 0) continue;
        face.depth[column] = depth_of(n, axis, high);
        face.any = face.any || face.depth[column] > 0.0F;
      }
    }
  }
}

EnteredTissue::EnteredTissue(const SlidingGrid& grid, const SlidingGrid::Field& displacement_voxels)
    : size_(grid.geometry().size) {
  FillFaces(grid, [&](std::int32_t n, int axis, bool high) {
    const float along = displacement_voxels[static_cast<std::size_t>(n)][axis];
    const float inwards = high ? -along : along;
    // One more: voxels at the front of what came in are averages with it.
    return inwards > kLeastMotionVoxels ? inwards + 1.0F : 0.0F;
  });
}

EnteredTissue::EnteredTissue(const SlidingGrid& grid, float depth_voxels)
    : size_(grid.geometry().size) {
  FillFaces(grid, [&](std::int32_t, int, bool) { return depth_voxels; });
}

bool EnteredTissue::Holds(const Eigen::Vector3f& at) const noexcept {
  for (int f = 0; f < 6; ++f) {
    const Face& face = faces_[static_cast<std::size_t>(f)];
    if (!face.any) continue;
    const int axis = f / 2;
    const auto [a, b] = AxesOf(axis);
    const int i = std::clamp(static_cast<int>(at[a] + 0.5F), 0, size_[a] - 1);
    const int j = std::clamp(static_cast<int>(at[b] + 0.5F), 0, size_[b] - 1);
    const float from_face = f % 2 == 1 ? static_cast<float>(size_[axis] - 1) - at[axis] : at[axis];
    const std::size_t column = static_cast<std::size_t>(j) * static_cast<std::size_t>(size_[a]) +
                               static_cast<std::size_t>(i);
    if (from_face < face.depth[column]) return true;
  }
  return false;
}

}  // namespace acus::breathing_registration
