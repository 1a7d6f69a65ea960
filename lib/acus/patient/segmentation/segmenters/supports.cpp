#include "acus/patient/segmentation/segmenters/supports.h"

#include <algorithm>
#include <limits>
#include <map>

namespace acus::segmentation {
namespace {

constexpr double kLeastLengthMm = 40.0;  ///< Along the axis of the slices.
constexpr double kLeastAlike = 0.8;      ///< Of the voxels, in columns that go through.
constexpr double kThrough = 0.9;         ///< Of the length.
constexpr int kAsBoneHu = 200;
constexpr double kMostDense = 0.01;

/// A part, looked at along the axis of the slices.
struct AxialProfile {
  std::map<std::size_t, int> columns;  ///< Voxels by the place in the slice.
  int first = std::numeric_limits<int>::max(), last = -1;
  std::size_t bone = 0;

  int length() const { return last - first + 1; }
};

std::map<std::int32_t, AxialProfile> AxialProfilesOf(const volume::CtVolume& ct,
                                                     const Components& parts,
                                                     const std::vector<std::uint8_t>& wanted,
                                                     int axis) {
  std::map<std::int32_t, AxialProfile> profiles;
  const auto& size = ct.geometry.size;
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const std::int32_t number = parts.number.At(i, j, k);
        if (number == 0 || wanted[static_cast<std::size_t>(number)] == 0) continue;
        Eigen::Array3i at(i, j, k);
        const int slice = at[axis];
        at[axis] = 0;
        AxialProfile& profile = profiles[number];
        ++profile.columns[ct.geometry.Index(at[0], at[1], at[2])];
        profile.first = std::min(profile.first, slice);
        profile.last = std::max(profile.last, slice);
        profile.bone += ct.At(i, j, k) > kAsBoneHu ? 1U : 0U;
      }
    }
  }
  return profiles;
}

bool IsSupport(const AxialProfile& profile, double spacing_mm, std::size_t num_voxels) {
  if (profile.length() * spacing_mm < kLeastLengthMm) return false;
  const auto all = static_cast<double>(num_voxels);
  double alike = 0.0;
  for (const auto& [column, count] : profile.columns) {
    if (count >= kThrough * profile.length()) alike += count;
  }
  return alike >= kLeastAlike * all && static_cast<double>(profile.bone) < kMostDense * all;
}

}  // namespace

std::vector<std::uint8_t> SupportsAmong(const volume::CtVolume& ct, const Components& parts,
                                        double least_ml, int axis) {
  const double ml = ct.geometry.voxel_volume_mm3() / 1000.0;
  std::vector<std::uint8_t> found(parts.num_voxels.size(), 0);
  for (std::size_t n = 1; n < found.size(); ++n) {
    found[n] = static_cast<double>(parts.num_voxels[n]) * ml >= least_ml ? 1 : 0;
  }
  const auto profiles = AxialProfilesOf(ct, parts, found, axis);
  for (const auto& [number, profile] : profiles) {
    const auto n = static_cast<std::size_t>(number);
    found[n] = IsSupport(profile, ct.geometry.spacing_mm[axis], parts.num_voxels[n]) ? 1 : 0;
  }
  return found;
}

}  // namespace acus::segmentation
