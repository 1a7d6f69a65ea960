// Voxels in memory: CT in Hounsfield units, and label maps.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "acus/base/core/error.h"
#include "acus/data/volume/geometry.h"

namespace acus::volume {

/// What marks voxels without data, HU.
inline constexpr std::int16_t kPaddingHu = -1024;

/// A scalar per voxel. voxels[geometry.Index(i, j, k)].
template <typename Scalar>
struct Grid {
  Geometry geometry;
  std::vector<Scalar> voxels;  ///< geometry.num_voxels().

  Grid() = default;
  explicit Grid(const Geometry& g, Scalar fill = Scalar{})
      : geometry(g), voxels(g.num_voxels(), fill) {}

  Scalar& At(int i, int j, int k) { return voxels[geometry.Index(i, j, k)]; }
  Scalar At(int i, int j, int k) const { return voxels[geometry.Index(i, j, k)]; }
};

/// CT in Hounsfield units. Padding outside the scanner's field of view is stored as -1024.
using CtVolume = Grid<std::int16_t>;

using Label = std::uint8_t;

/// A tissue label per voxel, 0 = outside the body, with a name for every label that occurs.
/// The names are those of configs/tissues: "skin", "fat", "bone", "liver", ...
struct LabelMap : Grid<Label> {
  using Grid<Label>::Grid;
  std::map<Label, std::string> names;
};

}  // namespace acus::volume
