// How the patient's own CT modulates the scatterers within each tissue.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "acus/data/volume/volume.h"

namespace acus::ultrasound {

/// Change of the echo level, dB, where the smoothed CT is this much denser than the tissue around.
/// Vessels full of contrast hold blood, which scatters less than parenchyma; fat strands scatter
/// more. Estimate.
double TextureDb(double hu_above_tissue);

/// Compares each voxel with its surroundings: the mean of tissues like it (soft tissues, not fat,
/// bone or gas) over some centimetres, or, in a labelled organ, the organ's median. The noise of
/// the CT is smoothed away first. Voxels at the border of their tissue are left alone: partial
/// volume says nothing of their texture.
class CtTexture {
 public:
  static constexpr float kMostGain = 1.6F;

  /// @pre both grids match.
  CtTexture(const volume::CtVolume& ct, const volume::LabelMap& labels, int num_threads);

  /// Factor of the scatterers' amplitude, at a voxel of the grid.
  float GainAt(std::size_t voxel) const { return gain_[code_[voxel]]; }

 private:
  /// kNone: no texture; kAround: against tissues around; kOrgan: against the median of its label.
  enum class Against : std::uint8_t { kNone, kAround, kOrgan };

  void FindTextured(const volume::LabelMap& labels);
  void FindMedians(const volume::CtVolume& ct, const volume::LabelMap& labels);
  void FindMeansAround(const volume::CtVolume& ct, const volume::LabelMap& labels);
  /// Mean of the tissues around, of the blocks along i at a row of voxels.
  void MeansOfRow(int j, int k, std::vector<float>& by_block) const;
  void CodeSlice(const volume::LabelMap& labels, int k, const std::vector<float>& smooth_hu);

  std::array<Against, 256> against_{};
  std::array<float, 256> median_hu_{};
  Eigen::Array3i block_;            ///< Voxels of one block of means, along each axis.
  Eigen::Array3i blocks_;           ///< Number of blocks along each axis.
  std::vector<float> mean_hu_;      ///< By block.
  std::vector<std::uint8_t> code_;  ///< By voxel; kNoTexture: gain 1.
  std::array<float, 256> gain_{};
};

}  // namespace acus::ultrasound
