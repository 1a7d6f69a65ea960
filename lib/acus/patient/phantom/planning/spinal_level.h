// A height of the spine: between two vertebrae.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

/// A level by the names of its vertebrae: "L3-L4", or "vertebra_5-vertebra_6" of unnamed ones.
struct NamedLevel {
  std::string name;
  SpinalLevel level;
};

/// All levels of the vertebrae.csv that acus-segment writes, from the head.
/// @throws InputError if the file is not there or broken.
std::vector<NamedLevel> ReadSpinalLevels(const std::filesystem::path& vertebrae_csv);

/// Those where the spinal cord has ended in nearly all adults, the usual one first.
std::span<const std::string_view> LumbarPunctureLevels();

/// The name of the level at whose height a point is; empty beyond all of them.
std::string LevelNameAt(std::span<const NamedLevel> levels, const Eigen::Vector3d& point_ct_mm);

/// Reads "L3-L4", the upper vertebra first, from the vertebrae.csv that acus-segment writes.
/// @throws InputError if the file is not there or broken, or has no such vertebrae next to each
///     other; it names those that it has.
SpinalLevel ReadSpinalLevel(const std::string& target, const std::filesystem::path& vertebrae_csv);

}  // namespace acus::phantom
