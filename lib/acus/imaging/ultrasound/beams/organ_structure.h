// What a CT does not resolve within and around organs, made from their labels.
#pragma once

#include <Eigen/Core>
#include <array>
#include <bitset>
#include <cstdint>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::ultrasound {

/// Structure of organs that sonographers look for, fixed in the tissue, by seed:
///
/// - kidney: pyramids and columns of the medulla below a cortex of 7 mm, and the sinus, where the
///   label is thick enough to include it;
/// - capsules of liver, kidney and spleen, walls of gallbladder, bladder and vessels;
/// - spinal canal: epidural fat and dura along its wall, with fluid inside;
/// - lumps of parenchyma: coarse in the pancreas, fine in the spleen.
///
/// One byte per voxel, only while the acoustic volume is made.
class OrganStructure {
 public:
  OrganStructure(const volume::LabelMap& labels, std::uint64_t seed);

  /// Factor of the scatterers' amplitude, at a voxel of the grid.
  float GainAt(std::size_t voxel) const { return gain_[code_[voxel]]; }
  /// Added to zeta = ln(Z) / 2 there.
  float ZetaAt(std::size_t voxel) const { return zeta_[code_[voxel]]; }

 private:
  /// What is done within a label.
  enum class Kind : std::uint8_t {
    kNone,
    kKidney,
    kLiver,
    kSpleen,
    kPancreas,
    kFluid,  ///< A wall and nothing inside.
    kCanal
  };

  void MeasureDepths(const volume::LabelMap& labels);
  void CodeVoxels(const volume::LabelMap& labels, std::uint32_t seed);
  std::uint8_t CodeOf(Kind kind, double depth_mm, double most_mm, const Eigen::Vector3d& place_mm,
                      std::uint32_t seed) const;

  std::array<Kind, 256> kind_{};
  std::bitset<256> within_;  ///< Vessels and lesions: they do not end an organ.
  double wall_mm_ = 0.0;     ///< Depth of the outermost layer of voxels.
  std::vector<std::uint8_t> code_;
  std::array<float, 256> gain_{};
  std::array<float, 256> zeta_{};
};

}  // namespace acus::ultrasound
