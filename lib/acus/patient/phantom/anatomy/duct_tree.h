// A tree of vessels or ducts that grows inside an organ.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::phantom {

/// A straight tube with round ends. In CT space (LPS), mm.
struct DuctSegment {
  int parent = -1;  ///< Index in its tree; -1: the first one.
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;

  double DistanceMm(const Eigen::Vector3d& point_mm) const;  ///< To its surface; < 0 inside.
};

struct DuctTreeSettings {
  double root_radius_mm = 4.0;
  double least_radius_mm = 0.9;  ///< Thinner branches do not fork.
  double margin_mm = 2.0;        ///< Between tubes and whatever is not free, and between tubes.
  double length_over_radius = 7.0;
  std::uint64_t seed = 0;
  std::string name;  ///< Of the random numbers: each tree has its own.
};

/// Where a tree may grow.
struct FreeSpace {
  /// Distance of each voxel's centre to the nearest one that is not free, mm.
  volume::Grid<float> distance_mm;

  /// A lower bound of the distance from a point to the centre of a voxel that is not free: that of
  /// the nearest voxel, less half its diagonal. Below 0 outside the grid.
  double ClearanceMm(const Eigen::Vector3d& point_mm) const;
  double ClearanceOf(int i, int j, int k) const;  ///< Of any point in a voxel.
};

/// Grows from the place nearest to `hint_mm` that the root fits in. Each tube ends in a fork of two
/// tubes that obey Murray's law, r^3 = r1^3 + r2^3 (Murray 1926, doi:10.1073/pnas.12.3.207), at the
/// angles of least work (Murray 1926, doi:10.1085/jgp.9.6.835), wider and shorter where there is
/// less room, or where no fork has room. The same input gives the same bits.
/// @param others  Tubes of other trees, that this one keeps `margin_mm` from.
/// @returns nothing if the root fits nowhere. @throws InputError for a setting out of range.
std::optional<std::vector<DuctSegment>> GrowDuctTree(const FreeSpace& space,
                                                     const Eigen::Vector3d& hint_mm,
                                                     std::span<const DuctSegment> others,
                                                     const DuctTreeSettings& settings);

/// Least distance between the axes of two segments, mm (Ericson 2004, section 5.1.9).
double AxisDistanceMm(const DuctSegment& a, const DuctSegment& b);

}  // namespace acus::phantom
