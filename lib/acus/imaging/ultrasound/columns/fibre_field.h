// The direction of the fibres of labelled tissue, from its surface alone.
#pragma once

#include <Eigen/Core>
#include <bitset>
#include <map>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::ultrasound {

/// Alamilla-2021, section V-A: fibres of tendon-like tissue run along the smallest principal
/// curvature of its surface. That is the direction in which the surface's normals change least: the
/// eigenvector of the sum of n n^T with the smallest eigenvalue, taken over a neighbourhood.
class FibreField {
 public:
  /// @param block_mm  Directions are constant in cubes of this size; the neighbourhood is five of
  ///     them wide. Where no surface is near, the direction is that of the whole label.
  FibreField(const volume::LabelMap& labels, const std::bitset<256>& fibrous,
             double block_mm = 6.0);

  /// Unit vector in CT space; both senses mean the same, neighbours agree. Zero for a label that is
  /// not fibrous or does not occur.
  /// @param index  Continuous voxel index.
  Eigen::Vector3f At(volume::Label label, const Eigen::Vector3f& index) const;

  /// Direction of the whole label. Zero as above.
  Eigen::Vector3f MainDirection(volume::Label label) const;

 private:
  struct Blocks {
    Eigen::Array3i size = Eigen::Array3i::Zero();
    Eigen::Array3f first_index = Eigen::Array3f::Zero();  ///< Corner of the first block.
    Eigen::Array3f per_index = Eigen::Array3f::Ones();    ///< Blocks per voxel.
    Eigen::Vector3f main = Eigen::Vector3f::Zero();
    std::vector<Eigen::Vector3f> direction;
  };
  static Blocks BlocksOf(const volume::LabelMap& labels, volume::Label label,
                         const Eigen::Array3i& low, const Eigen::Array3i& high, double block_mm);

  std::map<volume::Label, Blocks> blocks_;
};

}  // namespace acus::ultrasound
