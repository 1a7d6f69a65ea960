// A height of the spine: between two vertebrae.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <string_view>

namespace acus::phantom {

/// Where the bodies of two vertebrae are that lie one below the other.
struct SpinalLevel {
  Eigen::Vector3d upper_ct_mm;
  Eigen::Vector3d lower_ct_mm;

  /// Height of a point: 0 at the centre of the upper body, 1 at that of the lower one.
  double ShareAt(const Eigen::Vector3d& point_ct_mm) const;

  /// Is it at the space between the arches of the two? That is at the disc and somewhat below it.
  bool HasAt(const Eigen::Vector3d& point_ct_mm) const;
};

/// Is a target a level, such as "L3-L4", and no structure or point?
bool NamesSpinalLevel(std::string_view target);

/// Reads "L3-L4", the upper vertebra first, from the vertebrae.csv that acus-segment writes.
/// @throws InputError if the file is not there or broken, or has no such vertebrae next to each
///     other; it names those that it has.
SpinalLevel ReadSpinalLevel(const std::string& target, const std::filesystem::path& vertebrae_csv);

}  // namespace acus::phantom
