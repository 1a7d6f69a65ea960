// Which transfer function holds where: classes of labels, at the voxels of a CT.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::volume_rendering {

/// A class for each voxel of a CT; without labels, all are of class 0.
class TissueClasses {
 public:
  using ClassOfLabel = std::array<std::uint8_t, 256>;
  /// A set of classes, one bit each.
  using Set = std::uint32_t;
  static constexpr int kMaxClasses = 32;

  TissueClasses() = default;
  /// @param labels  On the same grid as the CT or another; outside of it the class is that of 0.
  TissueClasses(const volume::Geometry& ct, const volume::LabelMap& labels,
                const ClassOfLabel& class_of);

  /// i fastest; null: all voxels are of class 0.
  const std::uint8_t* data() const noexcept { return classes_.empty() ? nullptr : classes_.data(); }

  /// The classes of voxels from `low` to `high`, both included and within the grid.
  Set In(const Eigen::Array3i& low, const Eigen::Array3i& high) const noexcept;

 private:
  Eigen::Array3i size_ = Eigen::Array3i::Zero();
  std::vector<std::uint8_t> classes_;
};

}  // namespace acus::volume_rendering
